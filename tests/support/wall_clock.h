// CLOCK_MONOTONIC, for drivers that communicate with another thread or process.
#pragma once

#include <chrono>
#include <thread>

#include "haptics/loop/loop.h"

namespace stylet::test {

inline std::int64_t wallNow_ns() noexcept {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

inline const haptics::Clock kWallClock = {
    nullptr, [](void*) noexcept { return wallNow_ns(); },
    [](void*, std::int64_t t_ns) noexcept {
        const std::int64_t left_ns = t_ns - wallNow_ns();
        if (left_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(left_ns));
    }};

}  // namespace stylet::test
