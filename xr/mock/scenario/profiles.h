// The interaction profiles of OpenXR 1.0 and of extensions, with their components.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/devices.h"

namespace xrmock {

constexpr std::uint32_t kMaxImageSize = 8192;  // either side of a swapchain image, pixels

struct Profile {
    const char* path;
    const char* title;
    // By User: "input/select/click ..." separated by spaces. Empty for users without such a device.
    std::array<std::string_view, kUserCount> components;
    const char* extension = nullptr;  // required extension; null: core
};
using Extensions = std::set<std::string, std::less<>>;  // enabled extensions

// Finds a profile among all profiles, or among those that the enabled extensions allow. Null if there is
// none.
const Profile* findProfile(std::string_view path);
const Profile* findProfile(std::string_view path, const Extensions& extensions);

// Components of the profile for this user path, separated by spaces. Empty if the profile does not support
// the user path.
std::string_view findComponents(const Profile& profile, User user);
// Returns whether any profile has this component with a value for this user path. Poses and outputs have no
// value.
bool isValueOfAnyProfile(User user, std::string_view component);

// A binding path split into user path and component: "/user/hand/left" and "input/select/click".
struct BindingPath {
    User user;
    std::string component;
};
std::optional<BindingPath> splitBindingPath(std::string_view path);

// Returns whether the profile has this component or one below it ("input/select" for "input/select/click").
bool hasComponent(const Profile& profile, const BindingPath& binding, const Extensions& extensions);

// Components that an action of this type reads if bound to this path: one, or x and y for a vector. Empty
// if none fits the type.
std::vector<std::string> componentsFor(const Profile& profile, const BindingPath& binding, XrActionType type);

}  // namespace xrmock
