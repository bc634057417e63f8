// The same work on several threads; results must not depend on who does what.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace stylet::patient {

// Calls work(index) for every index in [0, count) on `threads` threads, the caller's among them, and
// `after()` now and then on the caller's. Neither may throw.
template <typename Work, typename After>
void parallelFor(int threads, std::size_t count, const Work& work, const After& after) {
    std::atomic<std::size_t> next{0};
    const auto takeOne = [&] {
        const std::size_t index = next.fetch_add(1, std::memory_order_relaxed);
        if (index < count) work(index);
        return index + 1 < count;
    };
    std::vector<std::thread> helpers;
    for (int i = 1; i < threads && std::size_t(i) < count; ++i)
        helpers.emplace_back([&] {
            while (takeOne()) {
            }
        });
    while (takeOne())
        after(std::min(next.load(std::memory_order_relaxed), count));
    for (std::thread& helper : helpers)
        helper.join();
}

template <typename Work>
void parallelFor(int threads, std::size_t count, const Work& work) {
    parallelFor(threads, count, work, [](std::size_t) {});
}

}  // namespace stylet::patient
