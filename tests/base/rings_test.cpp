#include "base/rings.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>
#include <vector>

namespace stylet {
namespace {

TEST(Ring, StoresItsCapacityAndCountsDrops) {
    Ring<int> ring(3);
    EXPECT_TRUE(ring.empty());
    EXPECT_TRUE(ring.push(1) && ring.push(2) && ring.push(3));
    EXPECT_FALSE(ring.empty());
    EXPECT_FALSE(ring.push(4));
    EXPECT_EQ(ring.dropped(), 1u);
    int v = 0;
    EXPECT_TRUE(ring.pop(v));
    EXPECT_EQ(v, 1);
    EXPECT_TRUE(ring.push(5));
    for (const int want : {2, 3, 5}) {
        ASSERT_TRUE(ring.pop(v));
        EXPECT_EQ(v, want);
    }
    EXPECT_FALSE(ring.pop(v));
    EXPECT_TRUE(ring.empty());
}

TEST(Ring, TwoThreadsLoseAndReorderNothing) {
    Ring<std::uint64_t> ring(64);
    constexpr std::uint64_t kCount = 200000;
    std::thread producer([&] {
        for (std::uint64_t i = 0; i < kCount; ++i)
            while (!ring.push(i))
                std::this_thread::yield();
    });
    std::uint64_t next = 0, v = 0;
    bool ordered = true;
    while (next < kCount) {
        while (!ring.pop(v))
            std::this_thread::yield();
        ordered = ordered && v == next++;
    }
    producer.join();
    EXPECT_TRUE(ordered);
}

struct Whole {
    std::uint64_t a = 0, b[30] = {}, c = 0;
};

TEST(Snapshot, IsNewOnce) {
    Snapshot<int> snapshot;
    int v = 7;
    EXPECT_FALSE(snapshot.read(v));
    snapshot.publish(1);
    snapshot.publish(2);
    EXPECT_TRUE(snapshot.read(v));
    EXPECT_EQ(v, 2);
    EXPECT_FALSE(snapshot.read(v));
    EXPECT_EQ(v, 2);
}

TEST(Snapshot, TwoThreadsSeeWholeValuesInOrder) {
    Snapshot<Whole> snapshot;
    constexpr std::uint64_t kCount = 200000;
    std::thread writer([&] {
        Whole w;
        for (std::uint64_t i = 1; i <= kCount; ++i) {
            w.a = w.c = i;
            for (std::uint64_t& b : w.b)
                b = i;
            snapshot.publish(w);
        }
    });
    Whole seen;
    std::uint64_t last = 0;
    bool whole = true, ascending = true;
    while (last < kCount) {
        if (!snapshot.read(seen)) {
            std::this_thread::yield();
            continue;
        }
        for (const std::uint64_t b : seen.b)
            whole = whole && b == seen.a;
        whole = whole && seen.a == seen.c;
        ascending = ascending && seen.a > last;
        last = seen.a;
    }
    writer.join();
    EXPECT_TRUE(whole);
    EXPECT_TRUE(ascending);
}

TEST(Latest, NewestValueIsFreshOnceAndRemains) {
    Latest<int> latest;
    EXPECT_FALSE(latest.update());
    for (const int value : {1, 2, 3}) {
        latest.draft() = value;
        latest.publish();
    }
    EXPECT_TRUE(latest.update());
    EXPECT_EQ(latest.front(), 3);
    EXPECT_FALSE(latest.update());
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
        if (!latest.update()) continue;
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
}  // namespace stylet
