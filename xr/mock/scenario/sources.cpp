#include "scenario/sources.h"

#include <algorithm>
#include <cmath>

namespace xrmock {

namespace {

const AutomatedDevice& automated(const Sources& sources, User user) {
    return sources.automation.devices[static_cast<std::size_t>(user)];
}

const Device& scripted(const Sources& sources, User user) {
    return sources.scenario.devices[static_cast<std::size_t>(user)];
}

SourceValue rawInputAt(const Sources& sources, User user, std::string_view component, std::int64_t time_ns) {
    if (sources.automation.in_control) {
        const auto& values = automated(sources, user).values;
        const auto found = values.find(component);
        return found == values.end() ? SourceValue{}
                                     : SourceValue{found->second.value, found->second.changed_ns};
    }
    const auto& values = scripted(sources, user).values;
    const auto keys = values.find(component);
    if (keys == values.end()) return {};
    const double t_s = sources.clock.scenarioSeconds(time_ns);
    const double changed_s = changeBefore(keys->second, t_s);
    const std::int64_t changed_ns =
        changed_s < 0 ? 0 : sources.clock.origin_ns + std::llround(changed_s * 1e9);
    return {valueAt(keys->second, t_s), std::max<std::int64_t>(changed_ns, 0)};
}

// The palm pose relative to the grip (XR_EXT_palm_pose): same position, with -z along the straight fingers
// instead of along the handle.
constexpr double kHalf = 0.70710678118654752;
constexpr Pose kGripFromPalm{{-kHalf, 0, 0, kHalf}, {0, 0, 0}};

}  // namespace

bool isButton(std::string_view component) {
    return component.ends_with("/click") || component.ends_with("/touch");
}

const std::string& profileAt(const Sources& sources, User user, std::int64_t time_ns) {
    static const std::string kNone;
    if (!sources.automation.in_control) {
        const double t_s = std::max(sources.clock.scenarioSeconds(time_ns), 0.0);
        return textAt(scripted(sources, user).profiles, t_s);
    }
    const AutomatedDevice& device = automated(sources, user);
    return device.active ? device.profile : kNone;
}

SourceValue inputAt(const Sources& sources, User user, std::string_view component, std::int64_t time_ns) {
    SourceValue source = rawInputAt(sources, user, component, time_ns);
    if (isButton(component)) {
        source.value = source.value >= kPressed ? 1 : 0;
    } else {
        const bool one_sided = component.ends_with("/value") || component.ends_with("/force");
        source.value = std::clamp(source.value, one_sided ? 0.0 : -1.0, 1.0);
    }
    return source;
}

Pose stageFromSource(const Sources& sources, User user, std::string_view component, std::int64_t time_ns) {
    const auto& set = automated(sources, user).stage_from_sources;
    if (const auto exact = set.find(component); exact != set.end()) return exact->second;
    const Device& device = scripted(sources, user);
    const auto fromGrip = [&](const Pose& stage_from_grip) {
        if (component == "input/aim/pose") return stage_from_grip * device.grip_from_aim;
        if (component == "input/palm_ext/pose") return stage_from_grip * kGripFromPalm;
        return stage_from_grip;
    };
    if (const auto grip = set.find("input/grip/pose"); grip != set.end()) return fromGrip(grip->second);
    if (const auto aim = set.find("input/aim/pose"); aim != set.end())
        return fromGrip(aim->second * inverse(device.grip_from_aim));
    if (device.grips.empty()) return {};
    return fromGrip(poseAt(device.grips, sources.clock.scenarioSeconds(time_ns)));
}

}  // namespace xrmock
