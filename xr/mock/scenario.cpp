#include "scenario.h"

#include <algorithm>
#include <cmath>

#include "json_fields.h"
#include "profiles.h"

namespace xrmock {

namespace {

// Every list of keys is ordered by a strictly increasing t_s.
double keyTime(const Field& key, double previous_s) {
    const double t_s = key.required("t_s").number(0, kMaxNumber);
    if (t_s <= previous_s) key.at("t_s").fail("later than the key before expected");
    return t_s;
}

std::vector<PoseKey> parsePoses(const Field& field) {
    std::vector<PoseKey> keys;
    double t_s = -1;
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.objectOf({"t_s", "position", "orientation"});
        t_s = keyTime(key, t_s);
        Pose pose;
        pose.position = key.required("position").numbers<3>(-kMaxNumber, kMaxNumber);
        if (key.has("orientation")) {
            auto q = key.at("orientation").numbers<4>(-kMaxNumber, kMaxNumber);
            const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
            if (length < 0.99 || length > 1.01)
                key.at("orientation").fail("a unit quaternion x y z w expected");
            for (double& component : q)
                component /= length;
            pose.orientation = q;
        }
        keys.push_back({t_s, pose});
    }
    if (keys.empty()) field.fail("at least one key expected");
    return keys;
}

double buttonValue(const Field& field) {
    if (field.value.is_boolean()) return field.value.get<bool>() ? 1 : 0;
    return field.number(-1, 1);
}

ControllerScenario parseController(const Field& field) {
    field.objectOf({"poses", "values"});
    ControllerScenario controller;
    controller.poses = parsePoses(field.required("poses"));
    if (!field.has("values")) return controller;
    const Field values = field.at("values");
    double t_s = -1;
    for (std::size_t i = 0; i < values.arraySize(); ++i) {
        const Field key = values.at(i);
        key.object();
        t_s = keyTime(key, t_s);
        for (const auto& [component, unused] : key.value.items()) {
            if (component == "t_s") continue;
            controller.values[component].push_back({t_s, buttonValue(key.at(component))});
        }
    }
    return controller;
}

void parseControllers(const Field& field, Scenario& scenario) {
    field.objectOf({"profile", "left", "right"});
    if (field.has("profile")) {
        scenario.profile = field.at("profile").text();
        if (findProfile(scenario.profile) == nullptr) field.at("profile").fail("not a profile of OpenXR 1.0");
    }
    const char* const names[2] = {"left", "right"};
    for (std::size_t hand = 0; hand < 2; ++hand) {
        scenario.controllers[hand].reset();
        if (field.has(names[hand])) scenario.controllers[hand] = parseController(field.at(names[hand]));
    }
}

XrFovf parseFov(const Field& field) {
    constexpr double kLimitRad = 1.55;  // short of a right angle
    const auto angles = field.numbers<4>(-kLimitRad, kLimitRad);
    if (angles[0] >= angles[1] || angles[3] >= angles[2]) field.fail("left < right and down < up expected");
    return {static_cast<float>(angles[0]), static_cast<float>(angles[1]), static_cast<float>(angles[2]),
            static_cast<float>(angles[3])};
}

void parseEyes(const Field& field, Scenario& scenario) {
    field.objectOf({"ipd_m", "recommended_size", "left_fov_rad", "right_fov_rad"});
    if (field.has("ipd_m")) scenario.ipd_m = field.at("ipd_m").number(0, 1);
    if (field.has("recommended_size")) {
        const auto size = field.at("recommended_size").numbers<2>(1, kMaxImageSize);
        scenario.width = static_cast<std::uint32_t>(size[0]);
        scenario.height = static_cast<std::uint32_t>(size[1]);
    }
    if (field.has("left_fov_rad")) scenario.eye_fov[0] = parseFov(field.at("left_fov_rad"));
    if (field.has("right_fov_rad")) scenario.eye_fov[1] = parseFov(field.at("right_fov_rad"));
}

SessionTarget parseTarget(const Field& field) {
    constexpr SessionTarget kTargets[] = {SessionTarget::focused, SessionTarget::visible,
                                          SessionTarget::synchronized, SessionTarget::stopped,
                                          SessionTarget::exiting};
    return kTargets[field.oneOf({"focused", "visible", "synchronized", "stopped", "exiting"})];
}

void parseSession(const Field& field, Scenario& scenario) {
    double t_s = -1;
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.objectOf({"t_s", "state"});
        t_s = keyTime(key, t_s);
        const TargetKey event{t_s, parseTarget(key.required("state"))};
        if (t_s == 0) scenario.session.clear();  // takes the place of the default
        scenario.session.push_back(event);
    }
}

}  // namespace

Scenario parseScenario(const std::string& text, const std::string& file_name) {
    const nlohmann::json document = parseJson(text, file_name);
    const Field root{document, file_name, ""};
    root.objectOf({"version", "refresh_hz", "exit_after_frames", "eyes", "stage_bounds_m", "head",
                   "controllers", "session"});
    root.required("version").number(1, 1);
    Scenario scenario;
    if (root.has("refresh_hz")) scenario.refresh_hz = root.at("refresh_hz").number(1, 1000);
    if (root.has("exit_after_frames")) {
        scenario.exit_after_frames = root.at("exit_after_frames").integer(1, 1'000'000'000);
    }
    if (root.has("eyes")) parseEyes(root.at("eyes"), scenario);
    if (root.has("stage_bounds_m")) scenario.stage_bounds_m = root.at("stage_bounds_m").numbers<2>(0.1, 1000);
    if (root.has("head")) scenario.head = parsePoses(root.at("head"));
    if (root.has("controllers")) parseControllers(root.at("controllers"), scenario);
    if (root.has("session")) parseSession(root.at("session"), scenario);
    return scenario;
}

Scenario loadScenario(const std::string& file_name) {
    return parseScenario(readTextFile(file_name), file_name);
}

Pose poseAt(const std::vector<PoseKey>& keys, double t_s) {
    const auto next = std::upper_bound(keys.begin(), keys.end(), t_s,
                                       [](double time_s, const PoseKey& key) { return time_s < key.t_s; });
    if (next == keys.begin()) return next->stage_from_device;
    const auto previous = next - 1;
    if (next == keys.end()) return previous->stage_from_device;
    return interpolate(previous->stage_from_device, next->stage_from_device,
                       (t_s - previous->t_s) / (next->t_s - previous->t_s));
}

double valueAt(const std::vector<ValueKey>& keys, double t_s) {
    const auto next = std::upper_bound(keys.begin(), keys.end(), t_s,
                                       [](double time_s, const ValueKey& key) { return time_s < key.t_s; });
    return next == keys.begin() ? 0.0 : (next - 1)->value;
}

SessionTarget targetAt(const Scenario& scenario, double t_s) {
    SessionTarget target = scenario.session.front().target;
    for (const TargetKey& key : scenario.session) {
        if (key.t_s <= t_s) target = key.target;
    }
    return target;
}

}  // namespace xrmock
