// The ray-march: what a step costs and how far its picture is from one with a tenth of a voxel; then, at the
// default step, what each skip is worth.
#include <algorithm>
#include <cstdio>
#include <functional>

#include "patient/synth/synth.h"
#include "tests/bench/bench.h"
#include "tests/render/pictures.h"
#include "tests/support/phantom.h"

namespace stylet::bench {
namespace {

using render::Look;
using render::RenderSettings;
using render::Vec3;

constexpr std::uint32_t kSize = 256;
constexpr int kRepeats = 5;

struct Stage {
    render::Renderer& renderer;
    render::RenderScene scene;
    std::array<render::View, 2> eyes;

    std::array<render::Image, 2> picture(const RenderSettings& settings, double* time_ms = nullptr) {
        renderer.setSettings(settings);
        auto eyes_seen = renderer.drawToImages(scene, eyes, kSize, kSize);  // compiles what is new
        std::vector<double> times;
        for (int i = 0; time_ms && i < kRepeats; ++i) {
            render::RenderStats stats;
            renderer.drawToImages(scene, eyes, kSize, kSize, &stats);
            times.push_back(stats.gpu_ms);
        }
        if (time_ms) *time_ms = median(times);
        return eyes_seen;
    }
};

// The patient on the table, seen from beside it by someone who bends over.
Stage bedside(render::Renderer& renderer, const patient::Patient& patient) {
    const patient::Grid& grid = patient.grid();
    const Vec3 middle = grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
    render::RenderScene scene;
    scene.stage_from_patient.position_m = Vec3(0.0, 1.0, 0.0) - middle;
    scene.breath = patient.package().breathing.reference;
    scene.patient_from_needle =
        render::Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), middle + Vec3(0.08, 0.02, 0.0)};
    return {renderer, scene,
            test::stereo(test::lookAt(Vec3(0.35, 1.35, 0.25), Vec3(0.03, 1.0, 0.0), 0.42f), 0.063)};
}

double worstPsnr(const std::array<render::Image, 2>& a, const std::array<render::Image, 2>& b) {
    // Equal pictures: the 8-bit round-off of one pixel in a million, so that a number stands in the table.
    return std::min({test::psnr(a[0], b[0]), test::psnr(a[1], b[1]), 108.0});
}

void stepRows(Stage& stage, const std::string& look, std::vector<Row>& rows) {
    const auto reference = stage.picture({.ray_step_voxels = 0.1f});
    for (const float step : {0.25f, 0.5f, 0.75f, 1.0f, 1.5f, 2.0f, 3.0f}) {
        double time_ms = 0.0;
        const auto eyes = stage.picture({.ray_step_voxels = step}, &time_ms);
        rows.push_back({"render.ray_step", "ray_step_voxels", double(step), time_ms,
                        worstPsnr(eyes, reference), "dB PSNR", "0.1 voxel",
                        look + ", both eyes at 256 x 256"});
    }
}

void skipRows(Stage& stage, const std::string& look, std::vector<Row>& rows) {
    const auto with_all = stage.picture({});
    const auto add = [&](const char* skip, bool on, const RenderSettings& settings) {
        double time_ms = 0.0;
        const auto eyes = stage.picture(settings, &time_ms);
        rows.push_back({"render.ray_step", skip, on ? 1.0 : 0.0, time_ms, worstPsnr(eyes, with_all),
                        "dB PSNR", "all skips on", look + ", default step"});
    };
    add("all skips", true, {});
    add("skip empty_space", false, {.skips = {.empty_space = false}});
    add("skip early_termination", false, {.skips = {.early_termination = false}});
    add("skip depth_bounds", false, {.skips = {.depth_bounds = false}});
    add("skip still_breath", false, {.skips = {.still_breath = false}});
    add("all skips", false, {.skips = {false, false, false, false}});
}

void run(std::vector<Row>& rows) {
    if (const std::string why = test::noGpuReason(); !why.empty()) {
        std::fprintf(stderr, "render.ray_step: %s\n", why.c_str());
        return;
    }
    patient::synth::SynthSettings settings;
    settings.spacing_m = 0.002;
    settings.defaults = test::tissueDefaults();
    const patient::Package package = patient::synth::makeReferencePatient(settings);
    const patient::Patient patient(package);
    render::Gpu gpu({});
    render::Renderer renderer(gpu, {}, test::assetsFolder());
    renderer.setPatient(patient);
    Stage stage = bedside(renderer, patient);
    for (const Look look : {Look::closed, Look::reveal}) {
        stage.scene.look = look;
        const std::string name = look == Look::closed ? "closed" : "reveal";
        stepRows(stage, name, rows);
        skipRows(stage, name, rows);
    }
}

const Registration registration("render.ray_step", run);

}  // namespace
}  // namespace stylet::bench
