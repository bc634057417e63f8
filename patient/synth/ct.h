// Converts labels to CT values: typical HU per tissue, blur and noise of the scanner.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "patient/synth/canvas.h"

namespace stylet::patient::synth {

// A voxel whose value differs from its label's, such as a calcification in the wall of a vessel.
struct Inclusion {
    std::size_t voxel;
    float hu;
};

// How the scanner shows the labels. The defaults are the reference patient's: ctRow(), noise of 11 HU, a soft
// kernel.
struct CtSettings {
    std::array<double, std::size_t(kIdCount)> mean_hu;   // over a label's voxels in the finished image
    std::array<double, std::size_t(kIdCount)> contrast;  // factor on the range from low_hu to high_hu
    double noise = 1.0;                                  // factor on the noise's standard deviation
    int blur_passes = 1;                                 // each with FWHM of 2 voxels
    std::vector<Inclusion> inclusions;                   // placed before the blur

    CtSettings();
};

// Rounded to whole HU. The mean of each label, without inclusions, is within a few HU of `mean_hu`.
CtVolume makeCt(const Canvas&, std::uint64_t seed, const CtSettings&);

}  // namespace stylet::patient::synth
