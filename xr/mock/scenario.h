// The scenario of a run (XRMOCK_SCENARIO): what the mock user and headset do over time. The README lists the
// fields.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "json_fields.h"
#include "pose.h"

namespace xrmock {

// Where a session is heading; ordered, so that less means less of a session.
enum class SessionTarget { exiting, stopped, synchronized, visible, focused };

struct PoseKey {
    double t_s;
    Pose stage_from_device;
};
struct ValueKey {
    double t_s;
    double value;
};
struct TargetKey {
    double t_s;
    SessionTarget target;
};

struct ControllerScenario {
    std::vector<PoseKey> poses;
    std::map<std::string, std::vector<ValueKey>> values;  // by component, e.g. "select/click"
};

struct Scenario {
    double refresh_hz = 90;
    std::optional<std::uint64_t> exit_after_frames;
    double ipd_m = 0.063;
    std::array<XrFovf, 2> eye_fov{XrFovf{-0.84F, 0.73F, 0.77F, -0.82F}, XrFovf{-0.73F, 0.84F, 0.77F, -0.82F}};
    std::uint32_t width = 640, height = 640;  // recommended per eye
    std::array<double, 2> stage_bounds_m{3, 3};
    std::vector<PoseKey> head{{0, {{0, 0, 0, 1}, {0, 1.6, 0}}}};
    std::string profile = "/interaction_profiles/khr/simple_controller";
    std::array<std::optional<ControllerScenario>, 2> controllers{
        ControllerScenario{{{0, {{0, 0, 0, 1}, {-0.2, 1.3, -0.4}}}}, {}},
        ControllerScenario{{{0, {{0, 0, 0, 1}, {0.2, 1.3, -0.4}}}}, {}}};
    std::vector<TargetKey> session{{0, SessionTarget::focused}};
};

Scenario parseScenario(const std::string& text, const std::string& file_name);  // throws FieldError
Scenario loadScenario(const std::string& file_name);                            // throws FieldError

// Before the first key its pose holds, after the last one the last.
Pose poseAt(const std::vector<PoseKey>& keys, double t_s);
// Holds from key to key; zero before the first.
double valueAt(const std::vector<ValueKey>& keys, double t_s);
SessionTarget targetAt(const Scenario& scenario, double t_s);

}  // namespace xrmock
