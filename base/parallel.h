// Loops on several threads. Results must not depend on which thread does which part.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "base/geometry.h"

namespace stylet {

// Calls work(index) for every index in [0, count) on `threads` threads, including the caller's. Also calls
// after(started) on the caller's thread from time to time, with the number of indices started. Neither
// function may throw.
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

// Calls change(first, stride, count) for every line along an axis of `dims` values, x-fastest.
template <typename Value, typename Change>
void parallelLines(int threads, const Index3& dims, int axis, Value* values, const Change& change) {
    const int across = axis == 2 ? 1 : 2, other = axis == 0 ? 1 : 0;
    const std::size_t strides[] = {1, std::size_t(dims.x), std::size_t(dims.x) * std::size_t(dims.y)};
    parallelFor(threads, std::size_t(dims[across]), [&](std::size_t n) {
        for (std::size_t m = 0; m < std::size_t(dims[other]); ++m)
            change(values + n * strides[across] + m * strides[other], strides[axis], std::size_t(dims[axis]));
    });
}

}  // namespace stylet
