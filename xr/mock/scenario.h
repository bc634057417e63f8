// The scenario of a run (XRMOCK_SCENARIO): what the mock user and headset do over time. SCENARIO.md lists the
// fields. Every instance has its own copy, which events and control messages change.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "assertions.h"
#include "devices.h"
#include "scenario_events.h"
#include "timeline.h"

namespace xrmock {

// What the runtime has to offer.
struct Offers {
    std::vector<XrEnvironmentBlendMode> blend_modes{XR_ENVIRONMENT_BLEND_MODE_OPAQUE};  // preferred first
    bool stage = true, local_floor = true, stationary = false;                          // spaces
    std::optional<std::vector<std::int64_t>> formats;  // nothing: all that the device has
};

struct Scenario {
    // The headset.
    std::string system_name = "XR Mock HMD";
    double refresh_hz = 90;                    // now
    std::vector<double> refresh_rates_hz{90};  // offered, from the lowest
    double ipd_m = 0.063;
    double eye_turn_rad = 0;  // each eye looks outward by this
    std::array<XrFovf, 2> eye_fov{XrFovf{-0.84F, 0.73F, 0.77F, -0.82F}, XrFovf{-0.73F, 0.84F, 0.77F, -0.82F}};
    std::array<LensOutline, 2> lens;
    bool pictures_through_lens = false;       // what a lens hides is black in captures
    std::uint32_t width = 640, height = 640;  // recommended per eye
    std::array<double, 2> stage_bounds_m{3, 3};

    // The user.
    std::vector<PoseKey> head{{0, {{0, 0, 0, 1}, {0, 1.6, 0}}}};
    std::array<Device, kUserCount> devices = restingDevices();
    std::array<TrackedHand, kHandCount> hands;
    bool hand_tracking = true;  // what the system says it supports

    // The runtime.
    Offers offers;
    std::vector<TargetKey> session{{0, SessionTarget::focused}};
    std::optional<std::uint64_t> exit_after_frames;
    std::vector<Event> events;  // those that are not over yet
    std::vector<Assertion> assertions;
};

Scenario parseScenario(const std::string& text, const std::string& file_name);  // throws FieldError
Scenario loadScenario(const std::string& file_name);                            // throws FieldError

// The rate is among those that the headset offers from now on.
void offerRefreshRate(Scenario& scenario, double hz);

// What both a scenario and a control message may hold: the user and the runtime, from now on.
void readTimelines(const Field& root, const Reading& reading, Scenario& scenario);  // throws FieldError

}  // namespace xrmock
