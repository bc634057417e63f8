// What the shaders make of single points: deform.glsl, run on the GPU over a list.
#pragma once

#include <vector>

#include "render/volume/deformed_patient.h"

namespace stylet::test {

// For each point of the deformed patient where the tables say that it came from.
std::vector<Vec3> referenceOnGpu(const render::Gpu&, render::DeformedPatient&,
                                 const std::vector<Vec3>& deformed_m);

}  // namespace stylet::test
