// Binding table of the controllers. Bindings are suggested for one profile at a time. If the runtime
// refuses a profile or a single button, the other ones still work.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "xr/instance.h"

namespace stylet::xr {

inline constexpr std::array<const char*, 2> kSides{"/user/hand/left", "/user/hand/right"};

struct Actions {
    XrAction grip = XR_NULL_HANDLE, aim = XR_NULL_HANDLE, select = XR_NULL_HANDLE, menu = XR_NULL_HANDLE,
             squeeze = XR_NULL_HANDLE, thumbstick = XR_NULL_HANDLE, haptic = XR_NULL_HANDLE;
};

XrPath toXrPath(XrInstance, const std::string& text);  // throws XrError

// Suggests bindings for every profile whose extension was granted. Adds a sentence to `notes` for each
// profile and each button that the runtime refuses.
void suggestBindings(const Instance&, const Actions&, std::vector<std::string>& notes);

}  // namespace stylet::xr
