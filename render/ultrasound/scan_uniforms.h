// Fills the buffers that the passes of a scan read.
#pragma once

#include "render/ultrasound/acoustics.h"
#include "render/ultrasound/contact.h"
#include "render/ultrasound/scan.h"
#include "render/ultrasound/scan_shared.h"

namespace stylet::render {

// Two-way attenuation in neper per metre.
double attenuation_np_per_m(const Acoustic&, double frequency_hz);

// Mapping from pixels to the picture's plane: metres per pixel, and the top left corner.
struct PictureView {
    double pixel_m = 0.0, left_m = 0.0, top_m = 0.0;
};
PictureView pictureView(const Transducer&, const UltrasoundSettings&, double depth_m);

inline constexpr int kDopplerColumns = 64, kDopplerRows = 96;

// Everything that determines one scan, except the patient.
struct ScanSetup {
    const ScanPlan& plan;
    const UltrasoundInput& input;
    const UltrasoundSettings& settings;
    const Transducer& probe;
    const AcousticTable& table;
};
// Fills all but deform_*, tool_*, flow_* and pulses.
void fillUniforms(const ScanSetup&, const Grid&, gpu::ScanUniforms& out);
void fillLines(const ScanSetup&, const Contact&, gpu::LineUniforms* out);
void fillDepths(const ScanPlan&, gpu::DepthUniforms* out);

}  // namespace stylet::render
