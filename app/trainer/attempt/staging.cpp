#include "app/trainer/attempt/staging.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/quaternion.hpp>

#include "patient/package/package.h"

namespace stylet::trainer {

namespace {

// Distance along -z from the operator's feet to the entry.
constexpr double kReach_m = 0.45;
constexpr double kEyeDistance_m = 0.48;
constexpr double kGazeAbove_m = 0.03;  // keeps the trunk, not the table, in the middle of the view
// Direction from the entry to the eyes of the leaning operator: above it, on the patient's right, a little
// toward the feet.
const Vec3 kLean = glm::normalize(Vec3{0.15, 0.80, 0.58});
// Limits of the angle between the line of sight and the line from the field's inside to its entry: large
// enough to see the length of a shaft there, small enough to see where it points.
constexpr double kMinSight_rad = 40.0 * std::numbers::pi / 180.0,
                 kMaxSight_rad = 75.0 * std::numbers::pi / 180.0;
constexpr Vec3 kUp{0.0, 1.0, 0.0};
constexpr double kTowardHilum_m = 0.035;  // offset of the isocentre from a target, toward the patient's left

// Lowest y of the body. Rows with only a few stray voxels do not count.
double backOf(const patient::Patient& patient) {
    constexpr int kFewVoxels = 200;
    const patient::Package& package = patient.package();
    const Grid& grid = package.ct.grid;
    const bool labelled = !package.label_table.empty();
    for (int y = 0; y < grid.dims.y; ++y) {
        int body = 0;
        for (int z = 0; z < grid.dims.z; ++z)
            for (int x = 0; x < grid.dims.x; ++x) {
                const std::size_t at = grid.offset({x, y, z});
                body += labelled ? package.labels.voxels[at] != 0
                                 : double(package.ct.voxels[at]) >= package.thresholds.t0_hu;
            }
        if (body >= kFewVoxels) return grid.centre({0, y, 0}).y - 0.5 * grid.spacing_m.y;
    }
    return grid.origin_m.y;
}

Quat lookAlong(const Vec3& forward) {
    const Vec3 back = -glm::normalize(forward);
    const Vec3 right = glm::normalize(glm::cross(kUp, back));
    return glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back)));
}

double sway(double amplitude_m, double frequency_hz, double t_s, double phase_rad) {
    return amplitude_m * std::sin(2.0 * std::numbers::pi * frequency_hz * t_s + phase_rad);
}

}  // namespace

OperativeField fieldOf(const patient::PlannedPath& path) noexcept {
    return {path.entry_m, path.target_m, path.entry_reference_m, isocentreFor(path.target_reference_m)};
}

Vec3 isocentreFor(const Vec3& target_m) noexcept {
    return target_m - Vec3(kTowardHilum_m, 0.0, 0.0);
}

OperativeField operativeField(const patient::Patient& patient, const patient::PlannedPath& path,
                              const training::DifficultyRules& rules) {
    return rules.showsEntry() ? fieldOf(path) : flankField(patient);
}

Pose stageFromPatient(const patient::Patient& patient, const OperativeField& field) {
    // Patient right -> stage +z (toward the operator), front -> +y, head -> -x.
    const double half = std::sqrt(0.5);
    const Quat rotation{half, 0.0, -half, 0.0};
    const Vec3 entry = rotation * field.entry_m;
    return {rotation, {-entry.x, kTableHeight_m - backOf(patient), -kReach_m - entry.z}};
}

OperativeField flankField(const patient::Patient& patient) {
    constexpr int kStride = 4, kSkin = 3;  // voxels that are skipped; consecutive voxels of body
    const Grid& grid = patient.grid();
    const auto tissueAt = [&](const Index3& i) { return patient.at(i, {true, true}).tissue; };
    Vec3 sum_m(0.0);
    std::size_t count = 0;
    for (Index3 i(0); i.z < grid.dims.z; i.z += kStride)
        for (i.y = 0; i.y < grid.dims.y; i.y += kStride)
            for (i.x = 0; i.x < grid.dims.x; i.x += kStride)
                if (tissueAt(i) == patient::Tissue::liver) sum_m += grid.centre(i), ++count;
    const Vec3 liver_m = count > 0 ? sum_m / double(count) : grid.centre(grid.dims / 2);
    Index3 at = grid.nearest(liver_m);
    int body = 0;
    for (at.x = grid.dims.x - 1; at.x > 0 && body < kSkin; --at.x)
        body = tissueAt(at) != patient::Tissue::air ? body + 1 : 0;
    at.x += body;
    const Vec3 flank_m = grid.centre(at);
    return {flank_m, liver_m, flank_m, liver_m};
}

Pose stageFromEyes(const Vec3& eyes_m, const Vec3& gaze_m) {
    return {lookAlong(gaze_m - eyes_m), eyes_m};
}

Pose stageFromHead(const Pose& stage_from_patient, const OperativeField& field, double t_s) {
    const Vec3 entry = stage_from_patient * field.entry_m, inside = stage_from_patient * field.inside_m;
    const Vec3 outward = glm::normalize(entry - inside);
    const double along = glm::dot(kLean, outward);
    const Vec3 beside = glm::normalize(kLean - along * outward);
    const double sight_rad = std::clamp(std::acos(along), kMinSight_rad, kMaxSight_rad);
    const Vec3 from_entry = std::cos(sight_rad) * outward + std::sin(sight_rad) * beside;

    const Vec3 gaze = glm::mix(entry, inside, 0.3) + kGazeAbove_m * kUp +
                      Vec3{sway(0.004, 0.13, t_s, 0.5), 0.0, sway(0.003, 0.09, t_s, 2.0)};
    const Vec3 eyes =
        entry + kEyeDistance_m * from_entry +
        Vec3{sway(0.014, 0.11, t_s, 0.0), sway(0.006, 0.23, t_s, 0.7), sway(0.010, 0.17, t_s, 1.0)};
    return stageFromEyes(eyes, gaze);
}

}  // namespace stylet::trainer
