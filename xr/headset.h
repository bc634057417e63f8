// What the headset is: its eyes, how it mixes what is drawn with the room, its refresh rate, and what its
// lenses hide.
#pragma once

#include <string>
#include <vector>

#include "xr/instance.h"

namespace stylet::xr {

struct Headset {
    XrEnvironmentBlendMode blend_mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    std::uint32_t width = 0, height = 0;  // of an eye's picture, the larger of the two, within the limits
    std::size_t max_layers = XR_MIN_COMPOSITION_LAYERS_SUPPORTED;
};

// Throws XrError unless it shows a picture to each of two eyes. Adds a note where there is no passthrough.
Headset readHeadset(const Instance&, bool passthrough, std::vector<std::string>& notes);
const char* nameOf(XrEnvironmentBlendMode);
double refreshRate_hz(const Instance&, XrSession);  // 0 where the runtime does not say
HiddenArea hiddenArea(const Instance&, XrSession, int eye);

}  // namespace stylet::xr
