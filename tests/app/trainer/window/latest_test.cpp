#include "app/trainer/window/latest.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace stylet::trainer {
namespace {

TEST(Latest, TheNewestIsTakenOnceAndStays) {
    Latest<int> latest;
    EXPECT_FALSE(latest.take());
    for (const int value : {1, 2, 3}) {
        latest.draft() = value;
        latest.publish();
    }
    EXPECT_TRUE(latest.take());
    EXPECT_EQ(latest.front(), 3);
    EXPECT_FALSE(latest.take());
    EXPECT_EQ(latest.front(), 3);
}

// Each value is a vector of a thousand equal numbers. A torn read would mix numbers.
TEST(Latest, ValuesArriveWholeAndInOrder) {
    constexpr int kValues = 20000;
    Latest<std::vector<int>> latest;
    std::thread writer([&] {
        for (int i = 1; i <= kValues; ++i) {
            latest.draft().assign(1000, i);
            latest.publish();
        }
    });
    int last = 0;
    while (last < kValues) {
        if (!latest.take()) continue;
        const std::vector<int>& value = latest.front();
        ASSERT_EQ(value.size(), 1000u);
        ASSERT_GT(value.front(), last);
        for (const int number : value)
            ASSERT_EQ(number, value.front());
        last = value.front();
    }
    writer.join();
}

}  // namespace
}  // namespace stylet::trainer
