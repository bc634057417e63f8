// Vibrations: what plays on which output, and a record of it for the log.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "devices.h"

namespace xrmock {

struct HapticPulse {
    std::uint64_t number = 0;  // 1 for the session's first
    std::uint64_t action = 0;  // the handle that it had
    std::string action_name;
    User user{};
    std::string output;                     // "output/haptic"
    std::int64_t start_ns = 0, end_ns = 0;  // XrTime; the end moves when it is stopped or interrupted
    double frequency_hz = 0;                // 0: the application left it open
    double amplitude = 0;                   // 0 to 1
};

struct Haptics {
    std::deque<HapticPulse> pulses;  // the newest last; the oldest of more than kMaxPulses are forgotten
    std::uint64_t started = 0;
};
constexpr std::size_t kMaxPulses = 4096;
constexpr std::int64_t kShortestPulseNs = 10'000'000;  // for XR_MIN_HAPTIC_DURATION

// Starts a pulse at pulse.start_ns; one that still plays on the same output ends there.
void startPulse(Haptics& haptics, HapticPulse pulse);
// Ends what the action plays on the output; action 0 means any.
void stopPulses(Haptics& haptics, std::uint64_t action, User user, std::string_view output,
                std::int64_t now_ns);
// Ends everything.
void stopAllPulses(Haptics& haptics, std::int64_t now_ns);

}  // namespace xrmock
