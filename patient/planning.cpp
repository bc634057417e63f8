// Based on Mastmeyer et al. 2017, Eq. 9, and Baegert et al. 2007 (strict and soft criteria on a ray set).
#include "patient/planning.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "patient/distance.h"
#include "patient/parallel.h"
#include "patient/planning_region.h"
#include "patient/traversal.h"

namespace stylet::patient {
namespace {

constexpr double kFullClearance_m = 0.010;  // C3 = 1
constexpr double kFullChord_m = 0.010;      // C4 = 1
constexpr double kBeyondTarget_m = 0.020;   // the far wall is looked for this far
constexpr double kUnderRibShare = 0.5;
constexpr double kChord_m = 0.001;   // pieces of a straight line that breath has bent in the reference
constexpr double kNeedle_m = 0.150;  // must come to the skin through free air
constexpr double kHair_m = 1e-5;
constexpr double kHandBehind_m = 0.190;  // where the hand holds it, before it touches the skin
constexpr double kHandAboveTable_m = 0.030;
constexpr double kSkinRoughness_m = 0.003;  // a slanting line leaves the voxelised skin this late

// The voxels of the REFERENCE along the straight line a + s * direction in the patient deformed by `breath`:
// visit(voxel, begin_m, end_m) until it returns false.
template <typename Visit>
void walkDeformed(const Patient& patient, const Surrogate& breath, const Vec3& a, const Vec3& direction,
                  double length_m, const Visit& visit) {
    const MotionModel& motion = patient.package().motion;
    const bool straight = motion.empty() || breath == motion.reference;
    bool going = true;
    const auto walkStretch = [&](double begin, double end) {
        const int pieces = straight ? 1 : std::max(1, int(std::ceil((end - begin) * length_m / kChord_m)));
        const double begin_m = begin * length_m, piece_m = (end - begin) * length_m / pieces;
        Vec3 from = referenceFromDeformed(motion, breath, a + direction * begin_m);
        for (int i = 0; i < pieces && going; ++i) {
            const double at_m = begin_m + piece_m * i;
            const Vec3 to = referenceFromDeformed(motion, breath, a + direction * (at_m + piece_m));
            for (VoxelWalk walk(patient.grid(), from, to); going && !walk.done(); walk.next())
                going = visit(walk.voxel(), at_m + piece_m * walk.begin(), at_m + piece_m * walk.end());
            from = to;
        }
    };
    forEachStretch(sideChanges(motion, breath, a, a + direction * length_m), walkStretch);
}

enum class Verdict { kept, blocked, tooLong, poor };

class Judge {
  public:
    Judge(const Patient& patient, const PlanSettings& settings, const PlanRegion& region)
        : patient_(patient), settings_(settings), region_(region) {
        const Vec3 s = patient.grid().spacing_m;
        half_voxel_m_ = 0.5 * std::max({s.x, s.y, s.z});
        step_m_ = std::min({s.x, s.y, s.z});
    }

    // Fills clearance, target score and quality of a path whose ends are set.
    Verdict judge(PlannedPath& path) const {
        path.length_m = glm::length(path.target_m - path.entry_m);
        if (!(path.length_m <= settings_.max_length_m)) return Verdict::tooLong;  // C2
        const Vec3 direction = (path.target_m - path.entry_m) / path.length_m;
        const std::optional<Duct> duct = traverse(path.entry_m, direction, path.length_m);  // C1
        if (!duct || !freeOutside(path, direction)) return Verdict::blocked;
        if (!betweenRibs(path, direction, duct->wall_m)) return Verdict::blocked;
        const double clearance_m = smallestClearance(path, direction, duct->wall_m - settings_.near_target_m);
        path.clearance_score = std::min(1.0, clearance_m / kFullClearance_m);  // C3
        path.target_score = std::min(1.0, duct->chord_m / kFullChord_m);       // C4
        path.quality = 0.5 * (path.clearance_score + path.target_score);
        if (path.quality < settings_.min_quality) return Verdict::poor;
        return freeBeside(path, direction) ? Verdict::kept : Verdict::blocked;
    }

  private:
    struct Duct {
        double wall_m = 0.0;  // depth of its near wall
        double chord_m = 0.0;
    };

    // The duct that holds the target, or nothing when a risk structure is on the way.
    std::optional<Duct> traverse(const Vec3& entry_m, const Vec3& direction, double length_m) const {
        TrackFlags flags;
        bool blocked = false, in_duct = false;
        double begin_of_duct_m = length_m, end_of_duct_m = length_m;
        const auto visit = [&](const Index3& voxel, double begin_m, double end_m) {
            const TissueSample sample = patient_.at(voxel, flags);
            flags = patient_.flagsAfterEntering(sample, flags);
            blocked = begin_m < length_m && sample.role == Role::risk;
            if (blocked) return false;
            if (end_m - begin_m < 1e-9) return true;  // a corner
            if (sample.tissue == Tissue::duct) {
                if (!in_duct) begin_of_duct_m = std::min(begin_m, length_m);
                end_of_duct_m = end_m;
                in_duct = true;
                return true;
            }
            if (end_m > length_m) return false;
            in_duct = false;
            begin_of_duct_m = end_of_duct_m = length_m;
            return true;
        };
        walkDeformed(patient_, settings_.breath, entry_m, direction, length_m + kBeyondTarget_m, visit);
        if (blocked) return std::nullopt;
        return Duct{begin_of_duct_m, end_of_duct_m - begin_of_duct_m};
    }

    // A line along a voxel's edge belongs to either side, and the last bit decides which a needle meets:
    // lines a hair beside the path must be free as well.
    bool freeBeside(const PlannedPath& path, const Vec3& direction) const {
        const Vec3 across = glm::normalize(glm::cross(direction, Vec3(0.0, 0.0, 1.0)) + Vec3(1e-9, 0.0, 0.0));
        const Vec3 upward = glm::cross(across, direction);
        for (const Vec3& aside : {across, -across, upward, -upward})
            if (!traverse(path.entry_m + aside * kHair_m, direction, path.length_m)) return false;
        return true;
    }

    // The path crosses the skin once: the needle comes to it through air, and the hand from above the table.
    bool freeOutside(const PlannedPath& path, const Vec3& direction) const {
        const double hand_m = path.entry_m.y - kHandBehind_m * direction.y;
        if (hand_m < region_.back_m + kHandAboveTable_m) return false;
        bool free = true, in_air = false;
        const auto visit = [&](const Index3& voxel, double begin_m, double) {
            const bool air = patient_.at(voxel, {}).tissue == Tissue::air;
            in_air = in_air || air;
            free = air || (!in_air && begin_m < kSkinRoughness_m);
            return free;
        };
        walkDeformed(patient_, settings_.breath, path.entry_m, -direction, kNeedle_m, visit);
        return free;
    }

    // The access is an intercostal space, where the flank has ribs at all.
    bool betweenRibs(const PlannedPath& path, const Vec3& direction, double depth_m) const {
        if (region_.intercostal.voxels.empty()) return true;
        for (double at_m = 0.0; at_m <= depth_m; at_m += step_m_)
            if (region_.intercostal.nearestOr(path.entry_m + direction * at_m, 0)) return true;
        return false;
    }

    // To the border of the nearest risk structure from the skin to `depth_m`; under a rib's lower edge half
    // counts.
    double smallestClearance(const PlannedPath& path, const Vec3& direction, double depth_m) const {
        double smallest_m = kFullClearance_m;
        const int steps = depth_m < 0.0 ? -1 : int(std::ceil(depth_m / step_m_));
        for (int i = 0; i <= steps; ++i) {
            const Vec3 p = path.entry_m + direction * std::min(i * step_m_, depth_m);
            const double risk_m = linearAt(region_.risk_m, p) - half_voxel_m_;
            const double rib_m = kUnderRibShare * (linearAt(region_.under_bone_m, p) - half_voxel_m_);
            smallest_m = std::min({smallest_m, risk_m, rib_m});
        }
        return std::max(0.0, smallest_m);
    }

    const Patient& patient_;
    const PlanSettings& settings_;
    const PlanRegion& region_;
    double half_voxel_m_ = 0.0, step_m_ = 0.0;
};

// All targets from one skin voxel: the best path, and what became of the others.
struct EntryResult {
    std::optional<PlannedPath> best;
    std::size_t blocked = 0, too_long = 0, poor = 0;
};

EntryResult planEntry(const Judge& judge, PlannedPath path, const std::vector<Vec3>& targets_reference_m,
                      const std::vector<Vec3>& targets_m) {
    EntryResult result;
    for (std::size_t t = 0; t < targets_m.size(); ++t) {
        path.target_m = targets_m[t];
        path.target_reference_m = targets_reference_m[t];
        switch (judge.judge(path)) {
            case Verdict::blocked:
                ++result.blocked;
                break;
            case Verdict::tooLong:
                ++result.too_long;
                break;
            case Verdict::poor:
                ++result.poor;
                break;
            case Verdict::kept:
                if (!result.best || path.quality > result.best->quality) result.best = path;
                break;
        }
    }
    return result;
}

// A total order: no two paths share their entry.
bool betterPath(const PlannedPath& a, const PlannedPath& b) {
    return std::tie(b.quality, a.length_m, a.entry_m.z, a.entry_m.y) <
           std::tie(a.quality, b.length_m, b.entry_m.z, b.entry_m.y);
}

}  // namespace

PlanResult planPaths(const Patient& patient, const PlanSettings& settings,
                     const std::function<void(double)>& progress) {
    const MotionModel& motion = patient.package().motion;
    const std::vector<Vec3> targets_reference_m = ductCentreLine(patient, settings.target_spacing_m);
    if (targets_reference_m.empty()) return {};
    if (progress) progress(0.1);
    std::vector<Vec3> targets_m;
    targets_m.reserve(targets_reference_m.size());
    for (const Vec3& t : targets_reference_m)
        targets_m.push_back(deformedFromReference(motion, settings.breath, t));
    const PlanRegion region = makePlanRegion(patient, settings);
    if (progress) progress(0.3);

    const Judge judge(patient, settings, region);
    std::vector<EntryResult> by_entry(region.entries_m.size());
    const auto planOne = [&](std::size_t e) {
        PlannedPath path;
        path.breath = settings.breath;
        path.entry_m = region.entries_m[e];
        path.entry_reference_m = referenceFromDeformed(motion, settings.breath, path.entry_m);
        by_entry[e] = planEntry(judge, path, targets_reference_m, targets_m);
    };
    parallelFor(settings.threads, by_entry.size(), planOne, [&](std::size_t done) {
        if (progress) progress(0.3 + 0.7 * double(done) / double(by_entry.size()));
    });

    PlanResult result;
    result.candidates = region.entries_m.size() * targets_m.size();
    for (const EntryResult& entry : by_entry) {
        if (entry.best) result.paths.push_back(*entry.best);
        result.rejected_blocked += entry.blocked;
        result.rejected_long += entry.too_long;
        result.rejected_quality += entry.poor;
    }
    std::sort(result.paths.begin(), result.paths.end(), betterPath);
    if (progress) progress(1.0);
    return result;
}

bool ratePath(const Patient& patient, const PlanSettings& settings, PlannedPath& path) {
    PlanSettings there = settings;
    there.breath = path.breath;
    path.clearance_score = path.target_score = path.quality = 0.0;
    const PlanRegion region = makePlanRegion(patient, there);
    return Judge(patient, there, region).judge(path) == Verdict::kept;
}

}  // namespace stylet::patient
