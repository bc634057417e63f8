// Properties of the headset: image size per eye, blend mode, refresh rate and the area hidden by its
// lenses.
#pragma once

#include <string>
#include <vector>

#include "xr/instance.h"

namespace stylet::xr {

struct Headset {
    XrEnvironmentBlendMode blend_mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    // Image size per eye [px]: the larger of the two eyes, within the runtime's limits.
    std::uint32_t width = 0, height = 0;
    std::size_t max_layers = XR_MIN_COMPOSITION_LAYERS_SUPPORTED;
};

// Throws XrError if the headset does not support stereo. Adds a note if passthrough was requested but is
// missing.
Headset readHeadset(const Instance&, bool passthrough, std::vector<std::string>& notes);
const char* blendModeName(XrEnvironmentBlendMode);
double refreshRate_hz(const Instance&, XrSession);  // 0 if the runtime does not report it
HiddenArea hiddenArea(const Instance&, XrSession, int eye);

}  // namespace stylet::xr
