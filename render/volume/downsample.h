// Downsamples a patient for a device that cannot hold it at full resolution.
#pragma once

#include "patient/patient.h"

namespace stylet::render {

// Merges blocks of factor^3 voxels into one with the mean CT value and the most frequent label. Ducts and
// vessels are thin, so their label wins if it fills a quarter of the block. For pictures only. factor >= 1.
patient::Package downsample(const patient::Package&, int factor);

}  // namespace stylet::render
