// Loops on several threads. The result must not depend on which thread executes which part.
#pragma once

#include <algorithm>
#include <atomic>
#include <concepts>
#include <cstddef>
#include <thread>
#include <vector>

#include "base/geometry.h"

namespace stylet {

// Processors of this machine, at least 1.
inline int processorCount() {
    return std::max(1, int(std::thread::hardware_concurrency()));
}

// Calls work(index) for every index in [0, count) on `threads` threads, including the caller's. Also calls
// after(started) on the caller's thread from time to time, with the number of indices started. Neither
// function may throw.
template <std::integral Index, typename Work, typename After>
void parallelFor(int threads, Index count, const Work& work, const After& after) {
    std::atomic<Index> next{0};
    const auto workOnce = [&] {
        const Index index = next.fetch_add(1, std::memory_order_relaxed);
        if (index < count) work(index);
        return index + 1 < count;
    };
    std::vector<std::thread> helpers;
    for (int i = 1; i < threads && Index(i) < count; ++i)
        helpers.emplace_back([&] {
            while (workOnce()) {
            }
        });
    while (workOnce())
        after(std::min(next.load(std::memory_order_relaxed), count));
    for (std::thread& helper : helpers)
        helper.join();
}

template <std::integral Index, typename Work>
void parallelFor(int threads, Index count, const Work& work) {
    parallelFor(threads, count, work, [](Index) {});
}

// Calls visit(voxel) for every voxel of the grid. Each slice is visited by one thread, in memory order.
template <typename Visit>
void parallelVoxels(int threads, const Grid& grid, const Visit& visit) {
    const Index3 last = grid.dims - 1;
    parallelFor(threads, grid.dims.z, [&](int z) { forEachVoxel({0, 0, z}, {last.x, last.y, z}, visit); });
}

// Calls change(first, stride, count) for every line of values along `axis`. `values` is a volume of `dims`
// values, x-fastest.
template <typename Value, typename Change>
void parallelLines(int threads, const Index3& dims, int axis, Value* values, const Change& change) {
    const int across = axis == 2 ? 1 : 2, other = axis == 0 ? 1 : 0;
    const std::size_t strides[] = {1, std::size_t(dims.x), std::size_t(dims.x) * std::size_t(dims.y)};
    parallelFor(threads, std::size_t(dims[across]), [&](std::size_t n) {
        for (std::size_t m = 0; m < std::size_t(dims[other]); ++m)
            change(values + n * strides[across] + m * strides[other], strides[axis], std::size_t(dims[axis]));
    });
}

// Filters a line with [1 2 1]/4, in place. The values at the ends are repeated beyond them.
inline void smoothLine(float* first, std::size_t stride, std::size_t count) noexcept {
    float before = first[0];
    for (std::size_t i = 0; i < count; ++i) {
        const float here = first[i * stride], after = i + 1 < count ? first[(i + 1) * stride] : here;
        first[i * stride] = 0.25f * before + 0.5f * here + 0.25f * after;
        before = here;
    }
}

}  // namespace stylet
