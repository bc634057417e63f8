// Measures the volume pass of one view, with the picture read back, for comparison with VTK's mappers
// (render_vtk.cpp has the same rows). Then measures the effect of each setting.
#include <cstdio>

#include "tests/bench/gpu.h"
#include "tests/bench/picture_case.h"
#include "tests/render/pictures.h"

namespace stylet::bench {
namespace {

using render::Look;
using render::RenderSettings;
using render::VolumePath;

// Both eyes are at the position of VTK's camera, so half of the frame's time is the time of one view.
struct Stage {
    render::Gpu gpu{{}};
    render::Renderer renderer{gpu, {}, test::assetsFolder()};
    render::RenderScene scene;
    std::array<render::View, 2> eyes;

    explicit Stage(const PictureCase& c)
        : eyes(test::stereo(test::lookAt(c.eye_m, c.at_m, float(c.half_angle)), 0.0)) {
        scene.table = false;
        scene.breath = c.package.motion.reference;
    }

    Pixels draw(const RenderSettings& settings, int size, render::RenderStats* stats = nullptr) {
        renderer.setSettings(settings);
        auto seen = renderer.drawToImages(scene, eyes, std::uint32_t(size), std::uint32_t(size), stats);
        return {size, size, std::move(seen[0].rgba)};
    }
};

RenderSettings reference() {
    return {.ray_step_voxels = 0.1f, .close_up = false, .far_steps = false};
}

void matched(Stage& stage, const std::string& look, std::vector<Row>& rows) {
    const auto draw = [&](int size, double step) {
        return stage.draw(step > 0.0 ? RenderSettings{.ray_step_voxels = float(step)} : reference(), size);
    };
    matchedRows("render.volume." + look, "", {6.0, 5.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.75, 0.5}, draw, rows, 0.5);
}

void knobs(Stage& stage, const std::string& look, std::vector<Row>& rows) {
    constexpr int kSize = 512;
    const Pixels truth = stage.draw(reference(), kSize);
    const auto add = [&](const char* knob, double value, const RenderSettings& settings) {
        const Pixels picture = stage.draw(settings, kSize);
        std::vector<double> times;
        for (int i = 0; i < 3; ++i) {
            render::RenderStats stats;
            stage.draw(settings, kSize, &stats);
            times.push_back(0.5 * stats.volume_ms);
        }
        rows.push_back({"render.volume." + look, knob, value, median(times), psnr(picture, truth), "dB PSNR",
                        "its own at 0.1 voxel", "volume pass of one view alone, 512 x 512"});
    };
    add("every skip", 1.0, {});
    add("skip empty_space", 0.0, {.skips = {.empty_space = false}});
    add("skip early_termination", 0.0, {.skips = {.early_termination = false}});
    add("no far_steps", 0.0, {.far_steps = false});
    add("layer scale", 0.5, {.layer_scale = 0.5f});
    add("by volume.comp", 1.0, {.volume_path = VolumePath::gpu});
}

// The slow case: the head is so close that the patient fills the view.
void close(Stage& stage, const PictureCase& c, const std::string& look, std::vector<Row>& rows) {
    const Vec3 away = glm::normalize(c.eye_m - c.at_m);
    const auto from = stage.eyes;
    for (const double distance_m : {0.7, 0.4, 0.25}) {
        stage.eyes = test::stereo(test::lookAt(c.at_m + distance_m * away, c.at_m, 0.7f), 0.0);
        const Pixels truth = stage.draw(reference(), 512);
        std::vector<double> times;
        for (int i = 0; i < 3; ++i) {
            render::RenderStats stats;
            stage.draw({}, 512, &stats);
            if (i > 0) times.push_back(0.5 * stats.volume_ms);
        }
        rows.push_back({"render.volume." + look, "eye to the middle, m", distance_m, median(times),
                        psnr(stage.draw({}, 512), truth), "dB PSNR", "its own at 0.1 voxel",
                        "volume pass of one view alone, 512 x 512, 80 degrees"});
    }
    stage.eyes = from;
}

void run(std::vector<Row>& rows) {
    if (!hasGpu("render.volume")) return;
    const PictureCase c;
    const patient::Patient patient(c.package);
    Stage stage(c);
    stage.renderer.setPatient(patient);
    for (const char* look : kPictureLooks) {
        stage.renderer.setLook(Look::reveal, pictureLook(look));
        matched(stage, look, rows);
        knobs(stage, look, rows);
        close(stage, c, look, rows);
    }
}

const Registration registration("render.volume", run);

}  // namespace
}  // namespace stylet::bench
