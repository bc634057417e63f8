// Tests whether multiview with two views really reaches both layers. Mesa 22.3's lavapipe claims so, but
// draws both views into layer 0.
#pragma once

#include "render/gpu/gpu.h"

namespace stylet::render {

// Draws one pixel in each view and reads both back. The device must have been created with the multiview
// feature.
bool probeMultiview(const Gpu&);

}  // namespace stylet::render
