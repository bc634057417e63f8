#include "app/trainer/staging.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "patient/package.h"
#include "xr/xr.h"

namespace stylet::trainer {

using patient::Pose;
using patient::Quat;
using patient::Vec3;

namespace {

// From the operator's feet to the entry, along -z.
constexpr double kReach_m = 0.45;
constexpr double kEyeDistance_m = 0.48;
constexpr double kGazeAbove_m = 0.03;  // the trunk, not the table, in the middle
// Where the operator leans, seen from the entry: above it, on the patient's right, a little toward the feet.
const Vec3 kLean = glm::normalize(Vec3{0.15, 0.80, 0.58});
// Between the line of sight and the planned shaft: enough to see its length, little enough to see where it
// points.
constexpr double kLeastSight_rad = 40.0 * std::numbers::pi / 180.0,
                 kMostSight_rad = 75.0 * std::numbers::pi / 180.0;
constexpr Vec3 kUp{0.0, 1.0, 0.0};

// The lowest part of the body: rows of a few stray voxels do not count.
double backOf(const patient::Patient& patient) {
    constexpr int kFewVoxels = 200;
    const patient::Package& package = patient.package();
    const patient::Grid& grid = package.ct.grid;
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

Pose stageFromPatient(const patient::Patient& patient, const patient::PlannedPath& path) {
    // Patient right -> stage +z (toward the operator), front -> +y, head -> -x.
    const double half = std::sqrt(0.5);
    const Quat rotation{half, 0.0, -half, 0.0};
    const Vec3 entry = rotation * path.entry_m;
    return {rotation, {-entry.x, kTableHeight_m - backOf(patient), -kReach_m - entry.z}};
}

Pose stageFromHead(const Pose& stage_from_patient, const patient::PlannedPath& path, double t_s) {
    const Vec3 entry = stage_from_patient * path.entry_m, target = stage_from_patient * path.target_m;
    const Vec3 outward = glm::normalize(entry - target);
    const double along = glm::dot(kLean, outward);
    const Vec3 beside = glm::normalize(kLean - along * outward);
    const double sight_rad = std::clamp(std::acos(along), kLeastSight_rad, kMostSight_rad);
    const Vec3 from_entry = std::cos(sight_rad) * outward + std::sin(sight_rad) * beside;

    const Vec3 gaze = glm::mix(entry, target, 0.3) + kGazeAbove_m * kUp +
                      Vec3{sway(0.004, 0.13, t_s, 0.5), 0.0, sway(0.003, 0.09, t_s, 2.0)};
    const Vec3 eyes =
        entry + kEyeDistance_m * from_entry +
        Vec3{sway(0.014, 0.11, t_s, 0.0), sway(0.006, 0.23, t_s, 0.7), sway(0.010, 0.17, t_s, 1.0)};
    return {lookAlong(gaze - eyes), eyes};
}

void writeHeadScript(const std::filesystem::path& file, const Pose& stage_from_patient,
                     const patient::PlannedPath& path) {
    constexpr double kLength_s = 120.0, kKeyEvery_s = 0.25;
    using nlohmann::json;
    json head = json::array();
    for (int i = 0; i * kKeyEvery_s <= kLength_s; ++i) {
        const Pose pose = stageFromHead(stage_from_patient, path, i * kKeyEvery_s);
        const Vec3& p = pose.position_m;
        const Quat& q = pose.rotation;
        head.push_back(
            {{"t_s", i * kKeyEvery_s}, {"position", {p.x, p.y, p.z}}, {"orientation", {q.x, q.y, q.z, q.w}}});
    }
    const json script{{"version", 1},
                      {"refresh_hz", 90},
                      {"eyes",
                       {{"ipd_m", kMockEyeDistance_m},
                        {"recommended_size", {640, 640}},
                        {"left_fov_rad", kMockEyeAngles_rad[0]},
                        {"right_fov_rad", kMockEyeAngles_rad[1]}}},
                      {"head", head}};
    std::ofstream out(file);
    out << script.dump(1) << '\n';
    out.close();
    if (!out) throw patient::DataError(file, "document", "cannot be written");
}

bool mockRuntimeChosen() {
    for (const std::filesystem::path manifest : xr::runtimeSearchPath()) {
        std::ifstream in(manifest);
        if (!in) continue;
        const auto json = nlohmann::json::parse(in, nullptr, false);
        if (!json.is_object() || !json.contains("runtime") || !json["runtime"].is_object()) return false;
        const auto library = json["runtime"].find("library_path");
        return library != json["runtime"].end() && library->is_string() &&
               std::filesystem::path(library->get<std::string>()).filename() == "libxrmock.so";
    }
    return false;
}

void setUpMock(const std::filesystem::path& head_script, bool virtual_clock,
               const std::filesystem::path& capture_dir) {
    setenv("XRMOCK_SCENARIO", head_script.c_str(), 1);
    setenv("XRMOCK_CLOCK", virtual_clock ? "virtual" : "real", 1);
    if (capture_dir.empty())
        unsetenv("XRMOCK_CAPTURE");
    else
        setenv("XRMOCK_CAPTURE", capture_dir.c_str(), 1);
}

}  // namespace stylet::trainer
