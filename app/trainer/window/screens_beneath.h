// A runtime lays the eyes' pictures over the machines' screens; so does this, for a copy of an eye.
#pragma once

#include <array>

#include "app/trainer/window/mirror_channels.h"

namespace stylet::trainer {

// Fills in what the eye's picture leaves clear. Null or empty: that screen is not there.
void showBeneath(EyeGiven&, const std::array<const render::Image*, 3>& screens);

}  // namespace stylet::trainer
