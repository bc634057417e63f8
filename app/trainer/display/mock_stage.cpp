#include "app/trainer/display/mock_stage.h"

#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/trainer/display/runtime_manifest.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/whole_file.h"
#include "patient/package/package.h"
#include "xr/xr.h"

namespace stylet::trainer {
namespace {

constexpr const char* kScenario = "XRMOCK_SCENARIO";

// Writes two minutes of stageFromHead() as a head motion script for the mock runtime. Each eye has 640 x 640
// pixels.
void writeHeadScript(const std::filesystem::path& file, const Pose& stage_from_patient,
                     const OperativeField& field) {
    constexpr double kLength_s = 120.0, kKeyEvery_s = 0.25;
    using nlohmann::json;
    json head = json::array();
    for (int i = 0; i * kKeyEvery_s <= kLength_s; ++i) {
        const Pose pose = stageFromHead(stage_from_patient, field, i * kKeyEvery_s);
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
    writeWholeFile(file, script.dump(1) + '\n');
}

}  // namespace

bool isMockRuntimeSelected() {
    for (const std::filesystem::path manifest : xr::runtimeSearchPath()) {
        if (std::error_code none; !std::filesystem::exists(manifest, none)) continue;
        return std::filesystem::path(readLibraryPath(manifest)).filename() == "libxrmock.so";
    }
    return false;
}

MockStage::MockStage(const MockSettings& settings, const Pose& stage_from_patient,
                     const OperativeField& field) {
    if (!isMockRuntimeSelected()) return;
    std::filesystem::path scenario = settings.scenario;
    if (scenario.empty() && !std::getenv(kScenario)) {
        written_ =
            std::filesystem::temp_directory_path() / ("stylet-head-" + std::to_string(processId()) + ".json");
        writeHeadScript(written_, stage_from_patient, field);
        scenario = written_;
    }
    scenario_set_ = !scenario.empty();
    if (scenario_set_) setenv(kScenario, scenario.c_str(), 1);
    setenv("XRMOCK_CLOCK", settings.virtual_clock ? "virtual" : "real", 1);
    if (settings.capture_dir.empty())
        unsetenv("XRMOCK_CAPTURE");
    else
        setenv("XRMOCK_CAPTURE", settings.capture_dir.c_str(), 1);
}

MockStage::~MockStage() {
    std::error_code nothing_there;
    if (!written_.empty()) std::filesystem::remove(written_, nothing_there);
    if (scenario_set_) unsetenv(kScenario);
}

}  // namespace stylet::trainer
