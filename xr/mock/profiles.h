// The interaction profiles of OpenXR 1.0 and the components each of them has.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "openxr_api.h"

namespace xrmock {

constexpr std::uint32_t kMaxImageSize = 8192;  // either side of a swapchain image, pixels

struct ProfileDevice {
    const char* user_path;   // "/user/hand/left"
    const char* components;  // "input/select/click ..." separated by blanks
};
struct Profile {
    const char* path;
    const char* title;
    std::span<const ProfileDevice> devices;
};

const Profile* findProfile(std::string_view path);

// /user/hand/left, right, /user/head, /user/gamepad, /user/treadmill
bool isTopLevelUserPath(std::string_view path);

// A binding path cut into its top level user path and the rest: "/user/hand/left" and "input/select/click".
struct BindingPath {
    std::string user_path;
    std::string component;
};
bool splitBindingPath(std::string_view path, BindingPath& out);

// Whether the profile has this component, or one below it ("input/select" for "input/select/click").
bool hasComponent(const Profile& profile, const BindingPath& binding);

// The components that an action of this type reads when bound to this path: one, or x and y for a vector.
// Empty when nothing there fits the type.
std::vector<std::string> componentsFor(const Profile& profile, const BindingPath& binding, XrActionType type);

}  // namespace xrmock
