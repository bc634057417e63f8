// Waits for an event in another thread or program. Only a failing test reaches the limit; a slow machine does
// not.
#pragma once

#include <chrono>

#include "tests/support/nap.h"

namespace stylet::test {

// Calls `done` once a millisecond until it returns true. Returns false after `limit`.
template <typename Done>
bool waitUntil(Done&& done, std::chrono::seconds limit = std::chrono::seconds(60)) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) return false;
        nap(1);
    }
    return true;
}

}  // namespace stylet::test
