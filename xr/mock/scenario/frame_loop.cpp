#include "scenario/frame_loop.h"

namespace xrmock {

FramePlan planFrame(const FrameLoop& loop, const Clock& clock, std::int64_t now_ns, std::int64_t period_ns,
                    std::uint32_t late_refreshes) {
    const std::int64_t late_ns = late_refreshes * period_ns;
    if (clock.is_virtual) {
        const std::int64_t display_ns =
            clock.virtual_now_ns < kVirtualStartNs ? kVirtualStartNs : clock.virtual_now_ns + period_ns;
        return {now_ns, display_ns + late_ns, late_refreshes};
    }
    // All numbers below count display refreshes since clock.origin_ns. `next` is the refresh after the last
    // one used. `reachable` is the first refresh that this frame can still reach. A paced application
    // normally has one full period from the return of xrWaitFrame to the refresh. If it is late by less than
    // one period, its frame starts at once and still targets `next`, as with real compositors.
    const std::int64_t reachable = (now_ns - clock.origin_ns) / period_ns + (loop.paced ? 1 : 2);
    const std::int64_t next = (loop.last_display_ns - clock.origin_ns) / period_ns + 1;
    const std::int64_t refresh = (next > reachable ? next : reachable) + late_refreshes;
    const std::int64_t display_ns = clock.origin_ns + refresh * period_ns;
    const std::int64_t missed = loop.paced ? refresh - next : late_refreshes;
    return {display_ns - period_ns, display_ns, static_cast<std::uint64_t>(missed)};
}

}  // namespace xrmock
