// The scenario of a run (XRMOCK_SCENARIO): behaviour of the simulated user and headset over time.
// SCENARIO.md lists the fields. Each instance has its own copy, which events and control messages change.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenario/assertions.h"
#include "scenario/devices.h"
#include "scenario/scenario_events.h"
#include "scenario/timeline.h"

namespace xrmock {

// Optional features that the runtime offers.
struct Offers {
    // Preferred mode first.
    std::vector<XrEnvironmentBlendMode> blend_modes{XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    bool stage = true, local_floor = true, stationary = false;  // spaces
    std::optional<std::vector<std::int64_t>> formats;           // nullopt: all formats of the device
};

struct Scenario {
    // The headset.
    std::string system_name = "XR Mock HMD";
    double refresh_hz = 90;                    // current rate
    std::vector<double> refresh_rates_hz{90};  // offered rates, ascending
    double ipd_m = 0.063;
    double eye_turn_rad = 0;  // each eye is rotated outward by this angle
    std::array<XrFovf, 2> eye_fov{XrFovf{-0.84F, 0.73F, 0.77F, -0.82F}, XrFovf{-0.73F, 0.84F, 0.77F, -0.82F}};
    std::array<LensOutline, 2> lens;
    bool pictures_through_lens = false;       // draw the area hidden by the lens black in captures
    std::uint32_t width = 640, height = 640;  // recommended per eye
    std::array<double, 2> stage_bounds_m{3, 3};

    // The user.
    std::vector<PoseKey> head{{0, {{0, 0, 0, 1}, {0, 1.6, 0}}}};
    std::array<Device, kUserCount> devices = restingDevices();
    std::array<TrackedHand, kHandCount> hands;
    bool hand_tracking = true;  // whether the system reports hand tracking as supported

    // The runtime.
    Offers offers;
    std::vector<TargetKey> session{{0, SessionTarget::focused}};
    std::optional<std::uint64_t> exit_after_frames;
    std::vector<Event> events;  // events not yet applied
    std::vector<Assertion> assertions;
};

Scenario parseScenario(const std::string& text, const std::string& file_name);  // throws FieldError
Scenario loadScenario(const std::string& file_name);                            // throws FieldError

// Adds the rate to those that the headset offers.
void addRefreshRate(Scenario& scenario, double hz);

// Reads the fields that are allowed in both scenarios and control messages: the user and the runtime.
void readTimelines(const Field& root, const ReadContext& context, Scenario& scenario);  // throws FieldError

}  // namespace xrmock
