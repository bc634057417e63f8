// The ray-march: what a step costs and how far its picture is from one with a tenth of a voxel; then, at the
// default step, what each skip is worth, against the same reference. The default is the cheapest step whose
// worst tile keeps kBoundDb: grain gathers on the glass skin, and a mean over the picture hides it.
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
constexpr std::uint32_t kTile = 64;
constexpr double kBoundDb = 40.0;
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
    scene.breath = patient.package().motion.reference;
    scene.patient_from_needle =
        render::Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), middle + Vec3(0.08, 0.02, 0.0)};
    return {renderer, scene,
            test::stereo(test::lookAt(Vec3(0.35, 1.35, 0.25), Vec3(0.03, 1.0, 0.0), 0.42f), 0.063)};
}

using Eyes = std::array<render::Image, 2>;

render::Image tileOf(const render::Image& image, std::uint32_t x0, std::uint32_t y0) {
    render::Image tile{kTile, kTile, {}};
    for (std::uint32_t y = y0; y < y0 + kTile; ++y) {
        const auto row = image.rgba.begin() + std::ptrdiff_t(4 * (y * image.width + x0));
        tile.rgba.insert(tile.rgba.end(), row, row + 4 * kTile);
    }
    return tile;
}

struct Distance {
    double whole_db = 108.0;  // the 8-bit round-off of one value in a million, so that equals have a number
    double tile_db = 108.0;   // of the worst tile
};

// Of the worse eye.
Distance distance(const Eyes& a, const Eyes& b) {
    Distance d;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        d.whole_db = std::min(d.whole_db, test::psnr(a[eye], b[eye]));
        for (std::uint32_t y = 0; y < kSize; y += kTile)
            for (std::uint32_t x = 0; x < kSize; x += kTile)
                d.tile_db = std::min(d.tile_db, test::psnr(tileOf(a[eye], x, y), tileOf(b[eye], x, y)));
    }
    return d;
}

// One picture against the reference: a row with both distances.
Row measure(Stage& stage, const Eyes& reference, const std::string& knob, double value,
            const RenderSettings& settings, const std::string& note) {
    double time_ms = 0.0;
    const Distance d = distance(stage.picture(settings, &time_ms), reference);
    char tile[64];
    std::snprintf(tile, sizeof tile, ", worst %u x %u tile %.1f dB%s", kTile, kTile, d.tile_db,
                  d.tile_db < kBoundDb ? ": too coarse" : "");
    return {"render.ray_step", knob, value, time_ms, d.whole_db, "dB PSNR", "0.1 voxel", note + tile};
}

void stepRows(Stage& stage, const Eyes& reference, const std::string& look, std::vector<Row>& rows) {
    for (const float step : {0.25f, 0.5f, 0.75f, 1.0f, 1.5f, 2.0f, 3.0f})
        rows.push_back(measure(stage, reference, "ray_step_voxels", double(step), {.ray_step_voxels = step},
                               look + (step == RenderSettings{}.ray_step_voxels ? ", default" : "")));
}

void skipRows(Stage& stage, const Eyes& reference, const std::string& look, std::vector<Row>& rows) {
    const auto add = [&](const char* skip, bool on, const RenderSettings& settings) {
        rows.push_back(measure(stage, reference, skip, on ? 1.0 : 0.0, settings,
                               look + (on ? ", default" : ", this one off")));
    };
    add("every skip", true, {});
    add("skip empty_space", false, {.skips = {.empty_space = false}});
    add("skip early_termination", false, {.skips = {.early_termination = false}});
    add("skip depth_bounds", false, {.skips = {.depth_bounds = false}});
    add("skip still_breath", false, {.skips = {.still_breath = false}});
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
        const Eyes reference = stage.picture({.ray_step_voxels = 0.1f});
        stepRows(stage, reference, name, rows);
        skipRows(stage, reference, name, rows);
    }
}

const Registration registration("render.ray_step", run);

}  // namespace
}  // namespace stylet::bench
