// XR_EXT_conformance_automation: a test sets the input in place of the scenario.
#include <cmath>

#include "api/api.h"
#include "scenario/profiles.h"
#include "world/objects.h"
#include "world/spaces.h"
#include "world/verify.h"

namespace xrmock {

namespace {

User requireUser(const Instance& instance, XrPath path) {
    const auto user = findUser(pathString(instance, path));
    require(user.has_value(), XR_ERROR_PATH_UNSUPPORTED, "not a top level user path");
    return *user;
}

// Returns the source's component, such as "input/select/click". The source must belong to the top level
// path.
std::string requireSource(const Instance& instance, User user, XrPath path) {
    auto source = splitBindingPath(pathString(instance, path));
    require(source && source->user == user && source->component.starts_with("input/"),
            XR_ERROR_PATH_UNSUPPORTED, "not an input source of the top level path");
    return std::move(source->component);
}

void requireValue(User user, const std::string& component) {
    require(isValueOfAnyProfile(user, component), XR_ERROR_PATH_UNSUPPORTED,
            "no interaction profile has such a value there");
}

void setValue(AutomatedDevice& device, const std::string& component, double value, std::int64_t now_ns) {
    AutomatedValue& held = device.values[component];
    if (value == held.value) return;
    held = {value, now_ns};
}

XrResult setNumber(Call& call, XrSession handle, XrPath top_level_path, XrPath source_path, double value) {
    Session& session = call.live<Session>(handle);
    const User user = requireUser(session.instance, top_level_path);
    const std::string component = requireSource(session.instance, user, source_path);
    requireValue(user, component);
    requireValid(std::isfinite(value), "state is not a number");
    setValue(session.automation.acquireDevice(user), component, value,
             session.instance.clock.now(call.now_ns));
    return XR_SUCCESS;
}

}  // namespace

XrResult setInputDeviceActive(Call& call, XrSession handle, XrPath profile_path, XrPath top_level_path,
                              XrBool32 active) {
    Session& session = call.live<Session>(handle);
    const std::string& profile = pathString(session.instance, profile_path);
    const Profile* known = findProfile(profile, session.instance.extensions);
    require(known != nullptr, XR_ERROR_PATH_UNSUPPORTED,
            "not an interaction profile of OpenXR 1.0 or an enabled extension");
    const User user = requireUser(session.instance, top_level_path);
    require(!findComponents(*known, user).empty(), XR_ERROR_PATH_UNSUPPORTED,
            "the interaction profile is not for this top level path");
    AutomatedDevice& device = session.automation.acquireDevice(user);
    device.active = active != XR_FALSE;
    device.profile = profile;
    return XR_SUCCESS;
}

XrResult setInputDeviceStateBool(Call& call, XrSession session, XrPath top_level_path, XrPath source_path,
                                 XrBool32 state) {
    return setNumber(call, session, top_level_path, source_path, state != XR_FALSE ? 1 : 0);
}

XrResult setInputDeviceStateFloat(Call& call, XrSession session, XrPath top_level_path, XrPath source_path,
                                  float state) {
    return setNumber(call, session, top_level_path, source_path, double{state});
}

XrResult setInputDeviceStateVector2f(Call& call, XrSession handle, XrPath top_level_path, XrPath source_path,
                                     XrVector2f state) {
    Session& session = call.live<Session>(handle);
    const User user = requireUser(session.instance, top_level_path);
    const std::string parent = requireSource(session.instance, user, source_path);
    requireValue(user, parent + "/x");
    requireValid(std::isfinite(state.x) && std::isfinite(state.y), "state is not a pair of numbers");
    AutomatedDevice& device = session.automation.acquireDevice(user);
    const std::int64_t now_ns = session.instance.clock.now(call.now_ns);
    setValue(device, parent + "/x", double{state.x}, now_ns);
    setValue(device, parent + "/y", double{state.y}, now_ns);
    return XR_SUCCESS;
}

XrResult setInputDeviceLocation(Call& call, XrSession handle, XrPath top_level_path, XrPath source_path,
                                XrSpace space_handle, XrPosef pose) {
    Session& session = call.live<Session>(handle);
    const User user = requireUser(session.instance, top_level_path);
    const std::string component = requireSource(session.instance, user, source_path);
    require(isHand(user) && (component == "input/grip/pose" || component == "input/aim/pose" ||
                             component == "input/palm_ext/pose"),
            XR_ERROR_PATH_UNSUPPORTED, "only the poses of a hand can be set");
    const Space& space = call.live<Space>(space_handle);
    requireValid(&space.session == &session, "the space is of another session");
    require(isValid(pose), XR_ERROR_POSE_INVALID, "pose is not a pose");
    const auto stage_from_space = stageFromSpace(space, session.instance.clock.now(call.now_ns));
    AutomatedDevice& device = session.automation.acquireDevice(user);
    // Ignore the location if the space cannot be located.
    if (stage_from_space) device.stage_from_sources[component] = *stage_from_space * fromXr(pose);
    return XR_SUCCESS;
}

}  // namespace xrmock
