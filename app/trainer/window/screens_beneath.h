// Draws the equipment screens beneath a copy of an eye image, as the OpenXR runtime does with its layers.
#pragma once

#include <array>

#include "app/trainer/window/mirror_channels.h"

namespace stylet::trainer {

// Fills in the transparent parts of the eye image. A screen that is null or empty is skipped.
void showBeneath(EyeUpdate&, const std::array<const render::Image*, 3>& screens);

}  // namespace stylet::trainer
