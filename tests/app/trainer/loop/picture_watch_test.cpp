#include "app/trainer/loop/picture_watch.h"

#include <gtest/gtest.h>

namespace stylet::trainer {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(PictureWatch, AStallIsReportedAtItsBeginAndItsEnd) {
    PictureWatch watch;
    EXPECT_EQ(watch.update(3 * kSecond_ns, 0, false), "") << "a slow frame";
    EXPECT_FALSE(watch.stalled());
    EXPECT_EQ(watch.update(3 * kSecond_ns + 1, 0, false),
              "the picture has stopped for 3 s; the attempt continues");
    EXPECT_TRUE(watch.stalled());
    EXPECT_EQ(watch.update(7 * kSecond_ns, 0, false), "") << "reported once";
    EXPECT_EQ(watch.update(7 * kSecond_ns, 7 * kSecond_ns, false),
              "the picture moves again; it had stopped for 7 s");
    EXPECT_FALSE(watch.stalled());
    EXPECT_EQ(watch.update(20 * kSecond_ns, 10 * kSecond_ns, true),
              "the picture has stopped for 10 s; the attempt stays paused");
}

// The notice stays long enough to be read, and as long as its consequence.
TEST(PictureWatch, TheNoticeEndsAfterTheStall) {
    PictureWatch watch;
    EXPECT_EQ(watch.shown_s(0, false), 0.0);
    EXPECT_EQ(watch.shown_s(0, true), 0.0) << "the force is off for another reason";
    watch.update(4 * kSecond_ns, 0, false);
    EXPECT_NEAR(watch.shown_s(4 * kSecond_ns, false), 4.0, 1e-9);
    watch.update(5 * kSecond_ns, 5 * kSecond_ns, false);
    EXPECT_NEAR(watch.shown_s(10 * kSecond_ns, false), 4.0, 1e-9);
    EXPECT_NEAR(watch.shown_s(60 * kSecond_ns, true), 4.0, 1e-9);
    EXPECT_EQ(watch.shown_s(60 * kSecond_ns, false), 0.0);
    EXPECT_EQ(watch.shown_s(61 * kSecond_ns, true), 0.0);
}

}  // namespace
}  // namespace stylet::trainer
