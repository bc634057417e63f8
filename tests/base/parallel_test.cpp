#include "base/parallel.h"

#include <gtest/gtest.h>

namespace stylet {
namespace {

TEST(ParallelFor, CallsEveryIndexOnce) {
    for (const int threads : {0, 1, 2, 7})
        for (const int count : {-1, 0, 1, 5, 1000}) {
            std::vector<std::atomic<int>> calls(std::size_t(std::max(count, 0)));
            parallelFor(threads, count, [&](int i) { ++calls[std::size_t(i)]; });
            for (const std::atomic<int>& called : calls)
                ASSERT_EQ(called, 1) << threads << " threads, " << count;
        }
}

TEST(ParallelFor, ReportsProgressOnTheCallersThread) {
    const std::thread::id caller = std::this_thread::get_id();
    std::size_t last = 0;
    bool own_thread = true;
    parallelFor(
        3, std::size_t(100), [](std::size_t) {},
        [&](std::size_t started) {
            own_thread = own_thread && std::this_thread::get_id() == caller && started >= last;
            last = started;
        });
    EXPECT_TRUE(own_thread);
    EXPECT_LE(last, 100u);
}

TEST(ParallelLines, VisitsEveryValueOfEveryAxis) {
    const Index3 dims(3, 4, 5);
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<int> values(3 * 4 * 5, 0);
        parallelLines(2, dims, axis, values.data(), [&](int* first, std::size_t stride, std::size_t count) {
            EXPECT_EQ(count, std::size_t(dims[axis]));
            for (std::size_t i = 0; i < count; ++i)
                first[i * stride] += int(i) + 1;
        });
        const Grid grid{dims};
        forEachVoxel(grid, [&](const Index3& i) { ASSERT_EQ(values[grid.offset(i)], i[axis] + 1); });
    }
}

TEST(ParallelVoxels, VisitsEveryVoxelOnce) {
    const Grid grid{{3, 4, 5}};
    std::vector<int> visits(grid.voxelCount(), 0);
    parallelVoxels(2, grid, [&](const Index3& i) { ++visits[grid.offset(i)]; });
    EXPECT_EQ(visits, std::vector<int>(grid.voxelCount(), 1));
}

TEST(SmoothLine, IsBinomialAndRepeatsTheEnds) {
    float values[] = {4.0f, 7.0f, 0.0f, 7.0f, 8.0f};
    smoothLine(values, 2, 3);  // every second value
    EXPECT_EQ(values[0], 3.0f);
    EXPECT_EQ(values[2], 3.0f);
    EXPECT_EQ(values[4], 6.0f);
    EXPECT_EQ(values[1], 7.0f);
}

}  // namespace
}  // namespace stylet
