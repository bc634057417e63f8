// The breath as the shader reads it (deform.glsl): rows over z of the deformed patient, with a CPU twin for
// tests.
#pragma once

#include <vector>

#include "patient/patient.h"
#include "render/frame_shared.h"

namespace stylet::render {

struct BreathRows {
    double z_begin_m = 0.0, dz_m = 1.0;
    double fade_rho = 2.0;
    std::vector<gpu::BreathRow> rows;  // at least two
};

// Always usable: where nothing moves, rows that map every point to itself.
BreathRows breathRows(const patient::BreathingModel&, const patient::Surrogate& now);

}  // namespace stylet::render
