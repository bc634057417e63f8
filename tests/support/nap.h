// Sleeps for a fixed time. To wait for an event use wait_until.h.
#pragma once

#include <chrono>
#include <thread>

namespace stylet::test {

inline void sleepMs(int ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

}  // namespace stylet::test
