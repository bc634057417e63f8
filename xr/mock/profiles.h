// The interaction profiles of OpenXR 1.0 and of extensions, and the components each of them has.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices.h"

namespace xrmock {

constexpr std::uint32_t kMaxImageSize = 8192;  // either side of a swapchain image, pixels

struct ProfileDevice {
    User user;
    std::string_view components;  // "input/select/click ..." separated by blanks
};
struct Profile {
    const char* path;
    const char* title;
    std::span<const ProfileDevice> devices;
    const char* extension = nullptr;  // that it takes; null: core
};
using Extensions = std::set<std::string, std::less<>>;  // the enabled ones

// Of all that there are, null for none; and of those that the application may use.
const Profile* findProfile(std::string_view path);
const Profile* findProfile(std::string_view path, const Extensions& extensions);

// Separated by blanks; empty if the profile is not for this user path.
std::string_view componentsOf(const Profile& profile, User user);
// Whether there is a profile with this component for this user path, and it has a value: no pose, no output.
bool isValueOfAnyProfile(User user, std::string_view component);

// A binding path cut in two: "/user/hand/left" and "input/select/click".
struct BindingPath {
    User user;
    std::string component;
};
std::optional<BindingPath> splitBindingPath(std::string_view path);

// Whether the profile has this component, or one below it ("input/select" for "input/select/click").
bool hasComponent(const Profile& profile, const BindingPath& binding, const Extensions& extensions);

// The components that an action of this type reads when bound to this path: one, or x and y for a vector.
// Empty when nothing there fits the type.
std::vector<std::string> componentsFor(const Profile& profile, const BindingPath& binding, XrActionType type);

}  // namespace xrmock
