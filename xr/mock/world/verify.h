// Checks that several API functions share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "world/call.h"
#include "world/objects.h"

namespace xrmock {

template <std::size_t kSize>
bool isTerminated(const char (&text)[kSize]) {
    return std::memchr(text, '\0', kSize) != nullptr;
}

template <std::size_t kSize>
void copyText(const char* text, char (&out)[kSize]) {
    std::strncpy(out, text, kSize - 1);
    out[kSize - 1] = '\0';
}

// Checks the type of each element that a two-call function will fill.
template <class Element>
void checkElements(std::uint32_t capacity, const Element* elements, std::size_t count, XrStructureType type) {
    if (elements == nullptr || capacity < count) return;  // nothing will be written
    for (std::size_t i = 0; i < count; ++i)
        requireValid(elements[i].type == type, "an element has the wrong type");
}

inline void requireSystem(XrSystemId system) {
    require(system == kSystemId, XR_ERROR_SYSTEM_INVALID, "the system id was not given out by xrGetSystem");
}

// Enumeration values of extensions that are not offered count as invalid.
inline void requireViewConfiguration(XrViewConfigurationType type) {
    requireValid(
        type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO || type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
        "the view configuration type is no known value");
    require(type == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
            "only primary stereo is offered");
}

inline void requireTime(XrTime time) {
    require(time > 0, XR_ERROR_TIME_INVALID, "a time must be greater than zero");
}

inline const std::string& pathString(const Instance& instance, XrPath path) {
    const std::string* string = instance.paths.toString(path);
    require(string != nullptr, XR_ERROR_PATH_INVALID,
            "the path is null or was not given out by xrStringToPath");
    return *string;
}

// Checks an action's subaction path: null, or one with which the action was created.
inline void requireSubaction(const Instance& instance, const Action& action, XrPath path) {
    if (path == XR_NULL_PATH) return;
    pathString(instance, path);
    require(std::find(action.subaction_paths.begin(), action.subaction_paths.end(), path) !=
                action.subaction_paths.end(),
            XR_ERROR_PATH_UNSUPPORTED, "the action was created without this subaction path");
}

constexpr XrDebugUtilsMessageSeverityFlagsEXT kAllSeverities =
    XR_DEBUG_UTILS_MESSAGE_SEVERITY_VERBOSE_BIT_EXT | XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT |
    XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
constexpr XrDebugUtilsMessageTypeFlagsEXT kAllTypes =
    XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
    XR_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT | XR_DEBUG_UTILS_MESSAGE_TYPE_CONFORMANCE_BIT_EXT;

inline const AttachedAction& attachedAction(const InputState& input, const Action& action) {
    const auto attached = input.actions.find(action.handle);
    require(attached != input.actions.end(), XR_ERROR_ACTIONSET_NOT_ATTACHED,
            "the action's set is not attached to the session");
    return attached->second;
}

inline void checkMessenger(const XrDebugUtilsMessengerCreateInfoEXT& info) {
    requireValid(info.messageSeverities != 0 && (info.messageSeverities & ~kAllSeverities) == 0,
                 "messageSeverities is empty or has unknown bits");
    requireValid(info.messageTypes != 0 && (info.messageTypes & ~kAllTypes) == 0,
                 "messageTypes is empty or has unknown bits");
    requireValid(info.userCallback != nullptr, "userCallback is null");
}

inline std::int64_t refreshPeriodNs(const Scenario& scenario) {
    return std::llround(1e9 / scenario.refresh_hz);
}

}  // namespace xrmock
