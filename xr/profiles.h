// What the controllers' buttons do: one suggestion for each controller profile, each on its own, so that one
// refusal costs only that controller, and one unknown button only itself.
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

XrPath pathOf(XrInstance, const std::string& text);  // throws XrError

// Suggests bindings for every profile whose extension was granted. Adds a sentence to `notes` for each
// profile, and for each button of one, that the runtime refuses.
void suggestBindings(const Instance&, const Actions&, std::vector<std::string>& notes);

}  // namespace stylet::xr
