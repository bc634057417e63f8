// Runs deform.glsl on the GPU over a list of points, to check what the shaders compute for single points.
#pragma once

#include <vector>

#include "render/volume/deformed_patient.h"

namespace stylet::test {

// For each point of the deformed patient, its position in the reference according to the tables.
std::vector<Vec3> referenceOnGpu(const render::Gpu&, render::DeformedPatient&,
                                 const std::vector<Vec3>& deformed_m);

}  // namespace stylet::test
