// Frame pacing, and the order of wait, begin and end. Reads no clock: time is an argument.
#pragma once

#include <cstdint>

#include "scenario/conditions.h"
#include "scenario/openxr_api.h"

namespace xrmock {

// Clock of an instance. Wall time is CLOCK_MONOTONIC. Virtual time is the display time of the last waited
// frame, and 1 ns before the first.
struct Clock {
    bool is_virtual = false;
    std::int64_t origin_ns = 0;       // scenario time 0
    std::int64_t virtual_now_ns = 1;  // a valid XrTime is greater than 0

    std::int64_t now(std::int64_t monotonic_ns) const { return is_virtual ? virtual_now_ns : monotonic_ns; }
    double scenarioSeconds(std::int64_t time_ns) const {
        return static_cast<double>(time_ns - origin_ns) * 1e-9;
    }
};

struct FramePlan {
    std::int64_t wake_ns;     // when xrWaitFrame may return, CLOCK_MONOTONIC
    std::int64_t display_ns;  // predicted display time
    std::uint64_t missed;     // refreshes that passed without a frame
};

struct FrameLoop {
    bool waiting = false;              // a thread is inside xrWaitFrame
    bool waited = false;               // a frame was waited for but not yet begun
    bool begun = false;                // a frame was begun but not yet ended
    bool paced = false;                // a frame was waited for since xrBeginSession
    std::int64_t last_display_ns = 0;  // increases over all runs of a session
    FrameOverride frame_override;      // of the frame that was waited for
    FrameOverride begun_override;      // of the frame that was begun
};

constexpr std::int64_t kVirtualStartNs = 1'000'000'000;

// Plans the next refresh that the frame can still reach, plus `late_refreshes`. Never returns the same
// refresh twice.
FramePlan planFrame(const FrameLoop& loop, const Clock& clock, std::int64_t now_ns, std::int64_t period_ns,
                    std::uint32_t late_refreshes);

}  // namespace xrmock
