// A clock that stands still until the test, or an emulator on its own thread, advances it. A driver that
// waits for an answer on this clock cannot time out because the machine is slow; only a lost answer advances
// the time.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "haptics/loop/loop.h"

namespace stylet::test {

struct SteppedClock {
    std::atomic<std::int64_t> now_ns{1'000'000'000};
    // Each reading of the clock advances it by this.
    std::atomic<std::int64_t> read_cost_ns{0};

    // The result must not outlive this object.
    haptics::Clock clock() noexcept {
        return {this,
                [](void* c) noexcept {
                    auto& self = *static_cast<SteppedClock*>(c);
                    const std::int64_t step_ns = self.read_cost_ns.load();
                    return self.now_ns.fetch_add(step_ns) + step_ns;
                },
                [](void* c, std::int64_t t_ns) noexcept { static_cast<SteppedClock*>(c)->advanceTo(t_ns); }};
    }
    void advanceTo(std::int64_t t_ns) noexcept {
        if (const std::int64_t left_ns = t_ns - now_ns.load(); left_ns > 0) now_ns.fetch_add(left_ns);
    }
    // Advances to `due_ns`, the next call of a PolledDevice, but by at least a millisecond.
    void advancePeriod(std::int64_t due_ns) noexcept {
        const std::int64_t step_ns = std::max(std::int64_t(1'000'000), due_ns - now_ns.load());
        now_ns.fetch_add(step_ns);
    }
};

}  // namespace stylet::test
