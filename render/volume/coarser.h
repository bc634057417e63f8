// The same patient in fewer voxels, for a device that cannot hold him as he is.
#pragma once

#include "patient/patient.h"

namespace stylet::render {

// Blocks of factor^3 voxels become one: the mean CT value, and the label that most of them have; ducts and
// vessels, thin as they are, already where a quarter of them does. For pictures only. factor >= 1.
patient::Package coarser(const patient::Package&, int factor);

}  // namespace stylet::render
