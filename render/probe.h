// Does multiview with two views really reach both layers? Mesa 22.3's lavapipe says so and draws both into
// layer 0.
#pragma once

#include "render/gpu.h"

namespace stylet::render {

// Draws one pixel in each view and reads both back. The device must have been made with the multiview
// feature.
bool probeMultiview(const Gpu&);

}  // namespace stylet::render
