// Waits for an event in another thread or program. A slow machine does not reach the limit; only a failing
// test does.
#pragma once

#include <chrono>

#include "tests/support/nap.h"

namespace stylet::test {

// Calls `done` every `nap_ms` until it returns true. Returns false after `limit`.
template <typename Done>
bool waitUntil(Done&& done, std::chrono::seconds limit = std::chrono::seconds(60), int nap_ms = 1) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        sleepMs(nap_ms);
    }
    return true;
}

}  // namespace stylet::test
