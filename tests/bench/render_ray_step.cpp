// Ray-march step: measures the render time of each step and the difference of its picture to a reference
// with a step of 0.1 voxel. Then turns each skip off at the default step and compares with the same
// reference. The default is the cheapest step whose worst tile meets kPictureBound_db. The worst tile is
// used because grain concentrates on the glass skin, and a mean over the picture hides it.
#include <cstdio>

#include "tests/bench/bedside.h"
#include "tests/bench/gpu.h"
#include "tests/bench/reference_patient.h"

namespace stylet::bench {
namespace {

using render::Look;
using render::RenderSettings;

// Renders one picture and compares it with the reference. The row has the distance of the whole picture
// and, in its note, that of the worst tile.
Row measure(Bedside& stage, const Eyes& reference, const std::string& knob, double value,
            const RenderSettings& settings, const std::string& note) {
    Bedside::DrawTimes times;
    const Distance d = distance(stage.picture(settings, &times), reference);
    return {"render.ray_step", knob,      value,       times.whole_ms,
            d.whole_db,        "dB PSNR", "0.1 voxel", note + ", " + tileNote(d)};
}

void stepRows(Bedside& stage, const Eyes& reference, const std::string& look, std::vector<Row>& rows) {
    for (const float step : {0.25f, 0.5f, 0.75f, 1.0f, 1.5f, 2.0f, 3.0f})
        rows.push_back(measure(stage, reference, "ray_step_voxels", double(step), {.ray_step_voxels = step},
                               look + (step == RenderSettings{}.ray_step_voxels ? ", default" : "")));
}

void skipRows(Bedside& stage, const Eyes& reference, const std::string& look, std::vector<Row>& rows) {
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
    if (!hasGpu("render.ray_step")) return;
    const patient::Package package = referencePatient(0.002);
    const patient::Patient patient(package);
    render::Gpu gpu({});
    render::Renderer renderer(gpu, {}, test::assetsFolder());
    renderer.setPatient(patient);
    Bedside stage = bedside(renderer, patient);
    for (const Look look : {Look::closed, Look::reveal}) {
        stage.scene.look = look;
        const std::string name = look == Look::closed ? "closed" : "reveal";
        const Eyes reference = stage.picture({.ray_step_voxels = 0.1f, .far_steps = false});
        stepRows(stage, reference, name, rows);
        skipRows(stage, reference, name, rows);
    }
}

const Registration registration("render.ray_step", run);

}  // namespace
}  // namespace stylet::bench
