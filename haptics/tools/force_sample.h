// The needle's force in one tick, as curves over the depth show it.
#pragma once

#include <cstdint>

#include "haptics/tools/needle.h"

namespace stylet::haptics {

// One tick inside the body.
struct ForceSample {
    std::uint64_t tick = 0;
    double depth_m = 0.0;  // of the tip along the track, from the skin
    double force_n = 0.0;  // axial, > 0 resists insertion
    Phase phase = Phase::outside;
    Tissue tissue = Tissue::air;
    bool breath_held = false;
};

}  // namespace stylet::haptics
