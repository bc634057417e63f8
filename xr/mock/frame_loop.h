// Frame pacing and the order of wait, begin and end. Reads no clock: the time is an argument.
#pragma once

#include <cstdint>

#include "conditions.h"
#include "openxr_api.h"

namespace xrmock {

// The clock of an instance. Wall time is CLOCK_MONOTONIC; virtual time stands at the display time of the
// frame that was waited for last, and at 0 before the first.
struct Clock {
    bool is_virtual = false;
    std::int64_t origin_ns = 0;       // scenario time 0
    std::int64_t virtual_now_ns = 1;  // an XrTime is greater than zero

    std::int64_t now(std::int64_t monotonic_ns) const { return is_virtual ? virtual_now_ns : monotonic_ns; }
    double scenarioSeconds(std::int64_t time_ns) const {
        return static_cast<double>(time_ns - origin_ns) * 1e-9;
    }
};

struct FramePlan {
    std::int64_t wake_ns;     // monotonic; when xrWaitFrame may return
    std::int64_t display_ns;  // predicted display time
    std::uint64_t missed;     // display refreshes that passed without a frame
};

struct FrameLoop {
    bool waiting = false;              // a thread is inside xrWaitFrame
    bool waited = false;               // a frame was waited for and not yet begun
    bool begun = false;                // a frame was begun and not yet ended
    bool paced = false;                // a frame was waited for since xrBeginSession
    std::int64_t last_display_ns = 0;  // grows over all runs of a session
    FrameFate fate;                    // of the frame that was waited for
    FrameFate begun_fate;              // of the frame that was begun
};

constexpr std::int64_t kVirtualStartNs = 1'000'000'000;

// The next refresh that can still be reached, or one so many later; never one that was handed out before.
FramePlan planFrame(const FrameLoop& loop, const Clock& clock, std::int64_t now_ns, std::int64_t period_ns,
                    std::uint32_t late_refreshes);

}  // namespace xrmock
