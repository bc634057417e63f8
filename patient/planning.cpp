// Based on Mastmeyer et al. 2017, Eq. 9, and Baegert et al. 2007 (strict and soft criteria on a ray set).
#include "patient/planning.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "patient/distance.h"
#include "patient/parallel.h"
#include "patient/planning_region.h"
#include "patient/tissue_map.h"
#include "patient/traversal.h"

namespace stylet::patient {
namespace {

constexpr double kFullClearance_m = 0.010;  // C3 = 1
constexpr double kFullChord_m = 0.010;      // C4 = 1
constexpr double kBeyondTarget_m = 0.020;   // the far wall is looked for this far
constexpr double kChord_m = 0.001;          // pieces of a straight line that breath has bent in the reference
constexpr double kNeedle_m = 0.150;         // must come to the skin through free air
constexpr double kHair_m = 1e-5;
constexpr double kHandBehind_m = 0.190;  // where the hand holds it, before it touches the skin
constexpr double kHandAboveTable_m = 0.030;
constexpr double kSkinRoughness_m = 0.003;  // a slanting line leaves the voxelised skin this late
constexpr double kCorner_m = 1e-9;          // a way shorter than this through a voxel touches its corner

bool isStill(const Patient& patient, const Surrogate& breath) {
    const MotionModel& motion = patient.package().motion;
    return motion.empty() || breath == motion.reference;
}

// The voxels of the REFERENCE along straight lines in the patient deformed by a breath. One a thread.
class Walker {
  public:
    Walker(const Patient& patient, const Surrogate& breath)
        : motion_(patient.package().motion),
          grid_(patient.grid()),
          breath_(breath),
          straight_(isStill(patient, breath)) {}

    // visit(a voxel's visit, begin_m, end_m) along a + s * direction, until it returns false.
    template <typename Visit>
    void walk(const Vec3& a, const Vec3& direction, double length_m, const Visit& visit) {
        bool going = true;
        const auto walkStretch = [&](double begin, double end) {
            const int pieces =
                straight_ ? 1 : std::max(1, int(std::ceil((end - begin) * length_m / kChord_m)));
            const double begin_m = begin * length_m, piece_m = (end - begin) * length_m / pieces;
            Vec3 from = referenceFromDeformed(motion_, breath_, a + direction * begin_m);
            for (int i = 0; i < pieces && going; ++i) {
                const double at_m = begin_m + piece_m * i;
                const Vec3 to = referenceFromDeformed(motion_, breath_, a + direction * (at_m + piece_m));
                const std::vector<VoxelPath::Visit>& visits = path_.along(grid_, from, to);
                for (std::size_t v = 0; v < visits.size() && going; ++v) {
                    const double share = v + 1 < visits.size() ? visits[v + 1].begin : 1.0;
                    going = visit(visits[v], at_m + piece_m * visits[v].begin, at_m + piece_m * share);
                }
                from = to;
            }
        };
        if (straight_)
            walkStretch(0.0, 1.0);
        else
            forEachStretch(sideChanges(motion_, breath_, a, a + direction * length_m), walkStretch);
    }

  private:
    const MotionModel& motion_;
    const Grid& grid_;
    Surrogate breath_;
    bool straight_;
    VoxelPath path_;
};

double scoreOf(double metres, double full_m) {
    return std::clamp(metres / full_m, 0.0, 1.0);
}
double qualityOf(double clearance_score, double target_score) {
    return 0.5 * (clearance_score + target_score);
}

enum class Verdict { kept, blocked, tooLong, poor };

// What all threads read.
struct Plan {
    const Patient& patient;
    const PlanSettings& settings;
    const PlanRegion& region;
    const TissueMap& map;
};

class Judge {
  public:
    explicit Judge(const Plan& plan)
        : map_(plan.map),
          settings_(plan.settings),
          region_(plan.region),
          walker_(plan.patient, plan.settings.breath) {}

    // Fills clearance, target score and quality of a path whose ends are set.
    Verdict judge(PlannedPath& path) {
        path.length_m = glm::length(path.target_m - path.entry_m);
        if (!(path.length_m <= settings_.max_length_m)) return Verdict::tooLong;  // C2
        const Vec3 direction = (path.target_m - path.entry_m) / path.length_m;
        const std::optional<Duct> duct = traverse(path.entry_m, direction, path.length_m);  // C1
        if (!duct) return Verdict::blocked;
        const Surroundings beside = lookAround(path, duct->wall_m);
        if (!beside.between_ribs) return Verdict::blocked;
        path.clearance_score = scoreOf(beside.clearance_m, kFullClearance_m);  // C3
        path.target_score = scoreOf(duct->chord_m, kFullChord_m);              // C4
        path.quality = qualityOf(path.clearance_score, path.target_score);
        if (path.quality < settings_.min_quality) return Verdict::poor;
        const bool free = freeOutside(path, direction) && freeBeside(path, direction);
        return free ? Verdict::kept : Verdict::blocked;
    }

  private:
    struct Duct {
        double wall_m = 0.0;  // depth of its near wall
        double chord_m = 0.0;
    };
    struct Surroundings {
        double clearance_m = kFullClearance_m;
        bool between_ribs = false;  // or where the flank has no ribs at all
    };

    // The duct that holds the target, or nothing when a risk structure is on the way.
    std::optional<Duct> traverse(const Vec3& entry_m, const Vec3& direction, double length_m) {
        TrackFlags flags;
        bool blocked = false, in_duct = false;
        double begin_of_duct_m = length_m, end_of_duct_m = length_m;
        const auto visit = [&](const VoxelPath::Visit& voxel, double begin_m, double end_m) {
            const TissueMap::Code code = map_.code(voxel);
            const TissueSample& sample = map_.sample(code, flags);
            flags = map_.flagsAfterEntering(code, flags);
            blocked = begin_m < length_m && sample.role == Role::risk;
            if (blocked) return false;
            if (end_m - begin_m < kCorner_m) return true;
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
        walker_.walk(entry_m, direction, length_m + kBeyondTarget_m, visit);
        if (blocked) return std::nullopt;
        return Duct{begin_of_duct_m, end_of_duct_m - begin_of_duct_m};
    }

    // A line along a voxel's edge belongs to either side, and the last bit decides which a needle meets:
    // lines a hair beside the path must be free as well.
    bool freeBeside(const PlannedPath& path, const Vec3& direction) {
        const Vec3 across = glm::normalize(glm::cross(direction, Vec3(0.0, 0.0, 1.0)) + Vec3(1e-9, 0.0, 0.0));
        const Vec3 upward = glm::cross(across, direction);
        for (const Vec3& aside : {across, -across, upward, -upward})
            if (!traverse(path.entry_m + aside * kHair_m, direction, path.length_m)) return false;
        return true;
    }

    // The path crosses the skin once: the needle comes to it through air, and the hand from above the table.
    bool freeOutside(const PlannedPath& path, const Vec3& direction) {
        const double hand_m = path.entry_m.y - kHandBehind_m * direction.y;
        if (hand_m < region_.back_m + kHandAboveTable_m) return false;
        bool free = true, in_air = false;
        const auto visit = [&](const VoxelPath::Visit& voxel, double begin_m, double) {
            const bool air = map_.sample(map_.code(voxel), {}).tissue == Tissue::air;
            in_air = in_air || air;
            free = air || (!in_air && begin_m < kSkinRoughness_m);
            return free;
        };
        walker_.walk(path.entry_m, -direction, kNeedle_m, visit);
        return free;
    }

    // Over the voxels of the deformed patient that the path visits: the smallest clearance as far as it
    // counts, and whether the access is an intercostal space.
    Surroundings lookAround(const PlannedPath& path, double wall_m) {
        const double counts_to_m = wall_m - settings_.near_target_m;
        const bool has_ribs = !region_.intercostal.voxels.empty();
        Surroundings found;
        found.between_ribs = !has_ribs;
        for (const VoxelPath::Visit& visit :
             around_.along(region_.clearance_m.grid, path.entry_m, path.target_m)) {
            const double begin_m = visit.begin * path.length_m;
            if (begin_m > wall_m) break;
            if (visit.offset == VoxelPath::kOutside) continue;
            const std::size_t voxel = std::size_t(visit.offset);
            if (begin_m < counts_to_m)
                found.clearance_m = std::min(found.clearance_m, double(region_.clearance_m.voxels[voxel]));
            found.between_ribs = found.between_ribs || region_.intercostal.voxels[voxel];
        }
        return found;
    }

    const TissueMap& map_;
    const PlanSettings& settings_;
    const PlanRegion& region_;
    Walker walker_;
    VoxelPath around_;
};

// Says of a pair, from few looks, that it cannot come to a quality. Every look that counts is at a voxel that
// the path surely visits: one that holds a point of the line and does not end just there. So what is found
// bounds what Judge would find, to the last bit.
class Doubter {
  public:
    explicit Doubter(const Plan& plan)
        : plan_(plan),
          grid_(plan.patient.grid()),
          corner_(grid_.nearest(plan.region.clearance_m.grid.origin_m)) {
        const Vec3 s = grid_.spacing_m;
        half_voxel_m_ = 0.5 * std::min({s.x, s.y, s.z});
    }

    // The best quality that the path could have, or something lower than `needed`.
    double bound(const PlannedPath& path, double needed) const {
        const double length_m = glm::length(path.target_m - path.entry_m);
        const Line line{grid_.toVoxels(path.entry_m) + 0.5,
                        (path.target_m - path.entry_m) / (grid_.spacing_m * length_m)};
        const double wall_m = outsideDuct(line, length_m, 0.0, -half_voxel_m_);
        const double far_m = outsideDuct(line, length_m, length_m + kBeyondTarget_m, half_voxel_m_);
        const double target_score = scoreOf(far_m - wall_m + kCorner_m, kFullChord_m);
        const double needed_m = (2.0 * needed - target_score) * kFullClearance_m;
        double clearance_m = kFullClearance_m;
        if (needed_m > clearance_m) return qualityOf(1.0, target_score);
        const double counts_to_m = wall_m - plan_.settings.near_target_m - kCorner_m;
        for (double at_m = 0.0; at_m < counts_to_m;) {
            const Look look = line.lookAt(at_m);
            const double here_m = clearance(look.voxel);
            if (look.sure) {
                clearance_m = std::min(clearance_m, here_m);
                if (here_m < needed_m || (here_m < 0.0 && blocks(look.voxel))) return kHopeless;
            }
            // A distance falls by no more than the way.
            at_m += std::max(here_m - std::max(0.0, needed_m), half_voxel_m_);
        }
        return qualityOf(scoreOf(clearance_m, kFullClearance_m), target_score);
    }

  private:
    static constexpr double kHopeless = -1.0;
    struct Look {
        Index3 voxel{0};
        bool sure = false;
    };
    struct Line {
        Vec3 start, step;  // in voxels, cell borders at integers
        // Truncation is no floor below zero; but what lies there is not sure.
        Look lookAt(double at_m) const {
            constexpr double kNear = 1e-4, kFar = 1.0 - kNear;
            const Vec3 at = start + step * at_m;
            const Index3 voxel(at);
            const Vec3 share = at - Vec3(voxel);
            return {voxel, share.x > kNear && share.y > kNear && share.z > kNear && share.x < kFar &&
                               share.y < kFar && share.z < kFar};
        }
    };

    double clearance(const Index3& voxel) const {
        const Volume<float>& clearance_m = plan_.region.clearance_m;
        const Index3 i = voxel - corner_;
        return clearance_m.grid.contains(i) ? double(clearance_m[i]) : kFullClearance_m;
    }
    // Whatever the needle has passed before.
    bool blocks(const Index3& voxel) const {
        const TissueMap::Code code = plan_.map.code(voxel);
        for (const bool past_skin : {false, true})
            for (const bool past_fascia : {false, true})
                if (plan_.map.sample(code, {past_skin, past_fascia}).role != Role::risk) return false;
        return true;
    }
    bool isDuct(const Index3& voxel) const {
        return plan_.map.sample(plan_.map.code(voxel), {}).tissue == Tissue::duct;
    }
    // The first depth on the way from `from_m` by `step_m` that is surely outside the duct, or `last_m`.
    double outsideDuct(const Line& line, double from_m, double last_m, double step_m) const {
        const int looks = int((last_m - from_m) / step_m);
        for (int i = 1; i <= looks; ++i) {
            const Look look = line.lookAt(from_m + i * step_m);
            if (look.sure && !isDuct(look.voxel)) return from_m + i * step_m;
        }
        return last_m;
    }

    const Plan& plan_;
    const Grid& grid_;
    Index3 corner_;  // of the region, in the patient's grid
    double half_voxel_m_ = 0.0;
};

struct Targets {
    std::vector<Vec3> reference_m, deformed_m;
};

// What became of the pairs of one skin voxel or more.
struct Counts {
    std::size_t skipped = 0, blocked = 0, too_long = 0, poor = 0;
};

// All targets from one skin voxel after another: neighbours have like paths, so the last one's target is
// tried first. Of equals the target that comes first in the list wins, whatever the order of trying.
class EntryPlanner {
  public:
    EntryPlanner(const Plan& plan, const Targets& targets)
        : plan_(plan),
          targets_(targets),
          judge_(plan),
          doubter_(plan),
          skips_(plan.settings.skip && isStill(plan.patient, plan.settings.breath)) {}

    std::optional<PlannedPath> plan(const Vec3& entry_m, Counts& counts) {
        best_.reset();
        path_ = {};
        path_.breath = plan_.settings.breath;
        path_.entry_m = entry_m;
        path_.entry_reference_m =
            referenceFromDeformed(plan_.patient.package().motion, path_.breath, entry_m);
        const std::size_t first = best_target_;
        tryTarget(first, counts);
        for (std::size_t t = 0; t < targets_.deformed_m.size(); ++t)
            if (t != first) tryTarget(t, counts);
        return best_;
    }

  private:
    // C2, where no rounding is at stake.
    bool isFarTooLong(std::size_t target) const {
        const double most_m = plan_.settings.max_length_m;
        const Vec3 way = targets_.deformed_m[target] - path_.entry_m;
        return glm::dot(way, way) > 1.01 * most_m * most_m;
    }
    bool isHopeless(std::size_t target) const {
        const double needed = best_ ? best_->quality : plan_.settings.min_quality;
        const double bound = doubter_.bound(path_, needed);
        return bound < needed || (best_ && bound == needed && target > best_target_);
    }
    void tryTarget(std::size_t target, Counts& counts) {
        if (skips_ && isFarTooLong(target)) {
            ++counts.too_long;
            return;
        }
        path_.target_m = targets_.deformed_m[target];
        path_.target_reference_m = targets_.reference_m[target];
        if (skips_ && isHopeless(target)) {
            ++counts.skipped;
            return;
        }
        const Verdict verdict = judge_.judge(path_);
        counts.blocked += verdict == Verdict::blocked;
        counts.too_long += verdict == Verdict::tooLong;
        counts.poor += verdict == Verdict::poor;
        if (verdict != Verdict::kept) return;
        if (best_ && path_.quality == best_->quality ? target > best_target_
                                                     : best_ && path_.quality < best_->quality)
            return;
        best_ = path_;
        best_target_ = target;
    }

    const Plan& plan_;
    const Targets& targets_;
    Judge judge_;
    Doubter doubter_;
    bool skips_;
    PlannedPath path_;
    std::optional<PlannedPath> best_;
    std::size_t best_target_ = 0;
};

// Entries of one height.
struct Row {
    std::size_t begin = 0, end = 0;
    std::vector<PlannedPath> paths;
    Counts counts;
};

std::vector<Row> rowsOf(const std::vector<Vec3>& entries_m) {
    std::vector<Row> rows;
    for (std::size_t e = 0; e < entries_m.size(); ++e) {
        if (e == 0 || entries_m[e].z != entries_m[e - 1].z) rows.push_back({e, e, {}, {}});
        rows.back().end = e + 1;
    }
    return rows;
}

// A total order: no two paths share their entry.
bool betterPath(const PlannedPath& a, const PlannedPath& b) {
    return std::tie(b.quality, a.length_m, a.entry_m.z, a.entry_m.y) <
           std::tie(a.quality, b.length_m, b.entry_m.z, b.entry_m.y);
}

}  // namespace

PlanSettings studyPlan(const Patient& patient) {
    PlanSettings settings;
    settings.breath = patient.package().motion.reference;
    settings.skin_spacing_m = settings.target_spacing_m = 0.0;
    return settings;
}

PlanResult planPaths(const Patient& patient, const PlanSettings& settings,
                     const std::function<void(double)>& progress) {
    const MotionModel& motion = patient.package().motion;
    Targets targets{ductCentreLine(patient, settings.target_spacing_m), {}};
    if (targets.reference_m.empty()) return {};
    if (progress) progress(0.1);
    for (const Vec3& t : targets.reference_m)
        targets.deformed_m.push_back(deformedFromReference(motion, settings.breath, t));
    const PlanRegion region = makePlanRegion(patient, settings);
    const TissueMap map(patient);
    if (progress) progress(0.3);

    const Plan plan{patient, settings, region, map};
    std::vector<Row> rows = rowsOf(region.entries_m);
    const auto planRow = [&](std::size_t r) {
        EntryPlanner planner(plan, targets);
        for (std::size_t e = rows[r].begin; e < rows[r].end; ++e)
            if (const auto best = planner.plan(region.entries_m[e], rows[r].counts))
                rows[r].paths.push_back(*best);
    };
    parallelFor(settings.threads, rows.size(), planRow, [&](std::size_t done) {
        if (progress) progress(0.3 + 0.7 * double(done) / double(rows.size()));
    });

    PlanResult result;
    result.candidates = region.entries_m.size() * targets.deformed_m.size();
    for (const Row& row : rows) {
        result.paths.insert(result.paths.end(), row.paths.begin(), row.paths.end());
        result.skipped += row.counts.skipped;
        result.rejected_blocked += row.counts.blocked;
        result.rejected_long += row.counts.too_long;
        result.rejected_quality += row.counts.poor;
    }
    std::sort(result.paths.begin(), result.paths.end(), betterPath);
    if (progress) progress(1.0);
    return result;
}

namespace {

PlanSettings inBreath(PlanSettings settings, const Surrogate& breath) {
    settings.breath = breath;
    return settings;
}

}  // namespace

bool ratePath(const Patient& patient, const PlanSettings& settings, PlannedPath& path) {
    const PlanSettings there = inBreath(settings, path.breath);
    path.clearance_score = path.target_score = path.quality = 0.0;
    const PlanRegion region = makePlanRegion(patient, there);
    const TissueMap map(patient);
    const Plan plan{patient, there, region, map};
    return Judge(plan).judge(path) == Verdict::kept;
}

std::vector<double> worstQualities(const Patient& patient, const PlanSettings& settings,
                                   const std::vector<PlannedPath>& paths,
                                   const std::vector<Surrogate>& breaths) {
    constexpr std::size_t kBlock = 64;
    const MotionModel& motion = patient.package().motion;
    const TissueMap map(patient);
    std::vector<double> worst(paths.size(), 1.0);
    for (const Surrogate& breath : breaths) {
        const PlanSettings there = inBreath(settings, breath);
        const PlanRegion region = makePlanRegion(patient, there);
        const Plan plan{patient, there, region, map};
        parallelFor(settings.threads, (paths.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
            Judge judge(plan);
            for (std::size_t i = block * kBlock; i < std::min(paths.size(), (block + 1) * kBlock); ++i) {
                PlannedPath path = paths[i];
                path.entry_m = deformedFromReference(motion, breath, path.entry_reference_m);
                path.target_m = deformedFromReference(motion, breath, path.target_reference_m);
                const bool kept = judge.judge(path) == Verdict::kept;
                worst[i] = std::min(worst[i], kept ? path.quality : 0.0);
            }
        });
    }
    return worst;
}

}  // namespace stylet::patient
