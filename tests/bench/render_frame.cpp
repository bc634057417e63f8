// Benchmark of one frame for both eyes, including the room. Reports the time for the opaque objects and for
// the volume, and the image error (PSNR). The error is relative to a reference picture with one ray per
// pixel and a ray step of 0.1 voxel. Parameters: the resolution of the volume's layer, foveation (fewer
// rays away from the viewing axis), the distance between eye and patient, and the setting `close_up`.

#include <fmt/core.h>

#include "tests/bench/bedside.h"
#include "tests/bench/gpu.h"
#include "tests/bench/reference_patient.h"

namespace stylet::bench {
namespace {

using render::Foveation;
using render::Look;
using render::RenderSettings;

constexpr RenderSettings kReference{.ray_step_voxels = 0.1f, .close_up = false, .far_steps = false};

Row row(Bedside& stage, const Eyes& reference, const std::string& knob, double value,
        const RenderSettings& settings, const std::string& look) {
    Bedside::DrawTimes times;
    const Distance d = distance(stage.picture(settings, &times), reference);
    const std::string parts =
        fmt::format("{} {} px: opaque {:.3g} ms, volume {:.3g} ms, layer {:.2f}; ", look, stage.pixels,
                    times.opaque_ms, times.volume_ms, times.last.layer_scale);
    return {"render.frame",     knob, value, times.whole_ms, d.whole_db, "dB PSNR", "0.1 voxel, every ray",
            parts + tileNote(d)};
}

void addRows(render::Renderer& renderer, const patient::Patient& patient, Look look, std::vector<Row>& rows) {
    const std::string name = look == Look::closed ? "closed" : "reveal";
    Bedside stage = bedside(renderer, patient);
    stage.scene.look = look;
    stage.scene.room = render::wholeRoom();
    for (const std::uint32_t pixels : {512u, 1024u}) {
        stage.pixels = pixels;
        const Eyes reference = stage.picture(kReference);
        for (const float scale : {1.0f, 0.75f, 0.5f, 0.35f})
            rows.push_back(row(stage, reference, "layer_scale", double(scale), {.layer_scale = scale}, name));
        if (pixels > 512u) break;
        rows.push_back(row(stage, reference, "foveation", 1.0, {.foveation = Foveation{}}, name));
    }
    for (const double distance_m : {1.0, 0.25, 0.12}) {
        Bedside near = bedside(renderer, patient, distance_m);
        near.scene.look = look;
        near.pixels = 512;
        const Eyes reference = near.picture(kReference);
        rows.push_back(row(near, reference, "eye_distance_m", distance_m, {}, name));
        rows.push_back(row(near, reference, "no close_up, m", distance_m, {.close_up = false}, name));
    }
}

void run(std::vector<Row>& rows) {
    if (!hasGpu("render.frame")) return;
    const patient::Package package = referencePatient(0.002);
    const patient::Patient patient(package);
    render::Gpu gpu({});
    render::Renderer renderer(gpu, {}, test::assetsFolder());
    renderer.setPatient(patient);
    for (const Look look : {Look::closed, Look::reveal})
        addRows(renderer, patient, look, rows);
}

const Registration registration("render.frame", run);

}  // namespace
}  // namespace stylet::bench
