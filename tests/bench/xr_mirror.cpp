// Cost of the instructor's window for the headset: frame times with the window, without it, and with a
// window whose display does not respond. The cases alternate within one run. The benchmark uses the real
// clock, the mock runtime and small eye images.
#include <array>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "app/installation.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/display/frames.h"
#include "app/trainer/window/mirror.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/bench/bench.h"
#include "tests/support/temp_folder.h"
#include "tests/support/x_display.h"

namespace stylet::bench {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using trainer::FrameLoop;

constexpr int kPixels = 256, kRounds = 25, kFrames = 12, kWarmUpFrames = 4;

enum class MirrorView { nobody, overview, leftEye, camera, stuck };
struct Case {
    MirrorView view;
    const char* keys;
    const char* note;
};
constexpr std::array kCases{
    Case{MirrorView::nobody, "", "no window"},
    Case{MirrorView::overview, "17", "the overview"},
    Case{MirrorView::leftEye, "1", "the left eye"},
    Case{MirrorView::camera, "3", "the free camera, on the same processors"},
    Case{MirrorView::stuck, "17", "the overview, and the display answers nobody"},
};

void setMockHeadPose(const std::filesystem::path& scenario, const Pose& head) {
    const auto& [q, at] = head;
    const json pose{{"t_s", 0}, {"position", {at.x, at.y, at.z}}, {"orientation", {q.x, q.y, q.z, q.w}}};
    std::ofstream(scenario) << json{
        {"version", 2}, {"eyes", {{"recommended_size", {kPixels, kPixels}}}}, {"head", json::array({pose})}};
    setenv("XRMOCK_SCENARIO", scenario.c_str(), 1);
    setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
}

void run(std::vector<Row>& rows) {
    const test::XDisplay display(1400, 900);
    const test::TempFolder folder;
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const patient::PlannedPath path = test::ductPath();
    const trainer::OperativeField field = trainer::flankField(patient);  // as in an exam
    setMockHeadPose(folder / "scenario.json",
                    trainer::stageFromHead(trainer::stageFromPatient(patient, field), field, 0.0));
    trainer::MirrorSettings settings;
    settings.pictures.assets = assetsFolder();
    settings.pictures.field = field;
    settings.pictures.config.difficulty = training::Difficulty::exam;  // no hints
    trainer::Mirror mirror(patient, path, settings);
    trainer::PictureSettings frame_settings;
    frame_settings.assets = settings.pictures.assets;
    frame_settings.field = field;
    FrameLoop loop(patient, frame_settings, path);
    loop.mirrorTo(mirror.channels());

    trainer::FrameState seen;
    seen.tick.patient_from_needle.position_m = {-0.01, 0.0, 0.0};
    const auto frames = [&](int count) {
        const std::size_t before = loop.totals().times.size();
        for (int i = 0; i < count; ++i) {
            seen.tick.tick += 11;
            loop.frame(seen, nullptr, "");
        }
        const auto times = loop.totals().times;
        std::vector<double> took_ms;
        for (std::size_t i = before; i < times.size(); ++i)
            took_ms.push_back(times[i].frame_ms);
        return took_ms;
    };
    std::array<std::vector<double>, kCases.size()> took_ms;
    std::array<std::uint64_t, kCases.size()> presented{};
    frames(2 * kWarmUpFrames);
    for (int round = 0; round < kRounds; ++round)
        for (std::size_t i = 0; i < kCases.size(); ++i) {
            // The frame loop treats a closed window as no window.
            mirror.channels().open.store(kCases[i].view != MirrorView::nobody);
            for (const char* key = kCases[i].keys; *key; ++key)
                display.key({key, 1});
            frames(kWarmUpFrames);
            if (kCases[i].view == MirrorView::stuck) display.stop();
            const std::uint64_t before = mirror.shown();
            const std::vector<double> some_ms = frames(kFrames);
            presented[i] += mirror.shown() - before;
            display.resume();
            took_ms[i].insert(took_ms[i].end(), some_ms.begin(), some_ms.end());
        }
    for (std::size_t i = 0; i < kCases.size(); ++i)
        rows.push_back({"xr.mirror", "window", double(i), median(took_ms[i]), quantile(took_ms[i], 0.99),
                        "ms, 99th percentile", "the first row",
                        std::string(kCases[i].note) + ": " + std::to_string(took_ms[i].size()) +
                            " frames of the headset, " + std::to_string(presented[i]) + " of the window"});
}

const Registration registration("xr.mirror", run);

}  // namespace
}  // namespace stylet::bench
