#include "patient/planning/planning_judge.h"

namespace stylet::patient {
namespace {

constexpr double kSideOffset_m = 1e-5;
constexpr double kHandBehindHub_m = 0.040;
constexpr double kHandAboveTable_m = 0.030;
constexpr double kSkinRoughness_m = 0.003;  // an oblique line may cross skin voxels up to this far

}  // namespace

double toScore(double metres, double full_m) noexcept {
    return std::clamp(metres / full_m, 0.0, 1.0);
}

double pathQuality(double clearance_score, double target_score) noexcept {
    return 0.5 * (clearance_score + target_score);
}

bool isReferenceBreath(const Patient& patient, const Surrogate& breath) {
    const MotionModel& motion = patient.package().motion;
    return motion.empty() || breath == motion.reference;
}

PathEvaluator::PathEvaluator(const Plan& plan)
    : map_(plan.map),
      settings_(plan.settings),
      region_(plan.region),
      walker_(plan.patient, plan.settings.breath) {}

Verdict PathEvaluator::evaluate(PlannedPath& path) {
    path.length_m = glm::length(path.target_m - path.entry_m);
    if (!(path.length_m <= settings_.max_length_m)) return Verdict::tooLong;  // C2
    const Vec3 direction = (path.target_m - path.entry_m) / path.length_m;
    const std::optional<Duct> duct = traverse(path.entry_m, direction, path.length_m);  // C1
    if (!duct) return Verdict::blocked;
    const Surroundings beside = findSurroundings(path, duct->wall_m);
    if (!beside.between_ribs || beside.uncertain) return Verdict::blocked;
    path.clearance_score = toScore(beside.clearance_m, kFullClearance_m);  // C3
    path.target_score = toScore(duct->chord_m, kFullChord_m);              // C4
    path.quality = pathQuality(path.clearance_score, path.target_score);
    if (path.quality < settings_.min_quality) return Verdict::poor;
    const bool free = isFreeOutside(path, direction) && isFreeBeside(path, direction);
    return free ? Verdict::accepted : Verdict::blocked;
}

// Finds the duct that contains the target. Returns nothing if the path meets a risk structure.
std::optional<PathEvaluator::Duct> PathEvaluator::traverse(const Vec3& entry_m, const Vec3& direction,
                                                           double length_m) {
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

// A line along a voxel's edge belongs to the voxels on both sides; rounding decides which of them a simulated
// needle meets. So lines slightly beside the path must be free of risk structures too.
bool PathEvaluator::isFreeBeside(const PlannedPath& path, const Vec3& direction) {
    const Vec3 across = glm::normalize(glm::cross(direction, Vec3(0.0, 0.0, 1.0)) + Vec3(1e-9, 0.0, 0.0));
    const Vec3 upward = glm::cross(across, direction);
    for (const Vec3& aside : {across, -across, upward, -upward})
        if (!traverse(path.entry_m + aside * kSideOffset_m, direction, path.length_m)) return false;
    return true;
}

// Checks that the path crosses the skin once: outside the skin the needle lies in air, and the hand stays
// above the table.
bool PathEvaluator::isFreeOutside(const PlannedPath& path, const Vec3& direction) {
    const double hand_m = path.entry_m.y - (settings_.needle_length_m + kHandBehindHub_m) * direction.y;
    if (hand_m < region_.back_m + kHandAboveTable_m) return false;
    bool free = true, in_air = false;
    const auto visit = [&](const VoxelPath::Visit& voxel, double begin_m, double) {
        const bool air = map_.sample(map_.code(voxel), {}).tissue == Tissue::air;
        in_air = in_air || air;
        free = air || (!in_air && begin_m < kSkinRoughness_m);
        return free;
    };
    walker_.walk(path.entry_m, -direction, settings_.needle_length_m, visit);
    return free;
}

// Examines the voxels of the deformed patient that the path visits. Finds the smallest clearance more than
// `near_target_m` before the duct's wall, whether a border there is uncertain, and whether the path passes
// between two ribs.
PathEvaluator::Surroundings PathEvaluator::findSurroundings(const PlannedPath& path, double wall_m) {
    const double counts_to_m = wall_m - settings_.near_target_m;
    const bool has_ribs = !region_.intercostal.voxels.empty();
    const bool has_borders = !region_.uncertain.voxels.empty();
    Surroundings found;
    found.between_ribs = !has_ribs;
    for (const VoxelPath::Visit& visit :
         around_.traverse(region_.clearance_m.grid, path.entry_m, path.target_m)) {
        const double begin_m = visit.begin * path.length_m;
        if (begin_m > wall_m) break;
        if (visit.offset == VoxelPath::kOutside) continue;
        const std::size_t voxel = std::size_t(visit.offset);
        const bool counts = begin_m < counts_to_m;
        if (counts)
            found.clearance_m = std::min(found.clearance_m, double(region_.clearance_m.voxels[voxel]));
        if (has_borders && region_.uncertain.voxels[voxel] > (counts ? 0 : 1)) found.uncertain = true;
        found.between_ribs = found.between_ribs || region_.intercostal.voxels[voxel];
    }
    return found;
}

}  // namespace stylet::patient
