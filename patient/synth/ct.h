// Converts labels to CT values: typical HU per tissue, blur and noise of the scanner.
#pragma once

#include "patient/synth/canvas.h"

namespace stylet::patient::synth {

// Rounded to whole HU. The mean of each label is within a few HU of its mean_hu in ctRow().
CtVolume makeCt(const Canvas&, std::uint64_t seed);

}  // namespace stylet::patient::synth
