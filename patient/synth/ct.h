// From labels to CT values: what each tissue measures, blurred by the scanner, with its noise.
#pragma once

#include "patient/synth/canvas.h"

namespace stylet::patient::synth {

// Rounded to whole HU. Each label's mean is its table's within a few HU.
CtVolume makeCt(const Canvas&, std::uint64_t seed);

}  // namespace stylet::patient::synth
