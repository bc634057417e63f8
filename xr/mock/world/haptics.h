// Haptic pulses that play on each output, with a history for the log and the assertions.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "scenario/assertions.h"
#include "scenario/devices.h"

namespace xrmock {

struct HapticPulse {
    std::uint64_t number = 0;  // 1 is the session's first pulse
    std::uint64_t action = 0;  // handle of the action
    std::string action_name;
    User user{};
    std::string output;                     // "output/haptic"
    std::int64_t start_ns = 0, end_ns = 0;  // XrTime; the end changes if the pulse is stopped or interrupted
    double frequency_hz = 0;                // 0: not specified
    double amplitude = 0;                   // 0 to 1
};

struct Haptics {
    std::deque<HapticPulse> pulses;  // newest last; at most kMaxPulses are kept
    std::uint64_t started = 0;
};
constexpr std::int64_t kMinPulseNs = 10'000'000;  // used for XR_MIN_HAPTIC_DURATION

// Starts a pulse at pulse.start_ns. A pulse still playing on the same output ends there.
void startPulse(Haptics& haptics, HapticPulse pulse);
// Stops the action's pulse on the output; action 0 means any action.
void stopPulses(Haptics& haptics, std::uint64_t action, User user, std::string_view output,
                std::int64_t now_ns);
void stopAllPulses(Haptics& haptics, std::int64_t now_ns);

}  // namespace xrmock
