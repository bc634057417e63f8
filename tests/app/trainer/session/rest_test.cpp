#include "app/trainer/session/rest.h"

#include <gtest/gtest.h>

#include <array>

#include "app/trainer/view/notice.h"

namespace stylet::trainer {
namespace {

// Advances in steps of one second. Returns the number of suggested rests.
int passes(RestWatch& watch, double& now_s, double seconds, bool works, bool inside) {
    int told = 0;
    for (double end_s = now_s + seconds; now_s < end_s; now_s += 1.0)
        told += watch.update(now_s, works, inside);
    return told;
}

// HZ-USER-02
TEST(Rest, IsSuggestedOnceAndNeverDuringAPuncture) {
    RestWatch watch;
    double now_s = 1e6;  // clocks do not start at zero
    EXPECT_EQ(passes(watch, now_s, kRestAfter_s - 60.0, true, false), 0);
    EXPECT_EQ(passes(watch, now_s, 300.0, true, true), 0);
    EXPECT_FALSE(watch.shown());
    EXPECT_EQ(passes(watch, now_s, 5.0, true, false), 1);
    EXPECT_TRUE(watch.shown());
    EXPECT_EQ(passes(watch, now_s, kRestShown_s, true, false), 0);
    EXPECT_FALSE(watch.shown());
    EXPECT_EQ(passes(watch, now_s, 3.0 * kRestAfter_s, true, false), 0) << "once";
    EXPECT_EQ(passes(watch, now_s, kRest_s + 5.0, false, false), 0);
    EXPECT_EQ(watch.worked_s(), 0.0);
    EXPECT_EQ(passes(watch, now_s, kRestAfter_s + 5.0, true, false), 1) << "rested, and at it again";
}

TEST(Rest, ShortPauseIsNeitherRestNorWork) {
    RestWatch watch;
    double now_s = 0.0;
    for (int i = 0; i < 10; ++i) {
        passes(watch, now_s, 60.0, true, false);
        passes(watch, now_s, kRest_s - 10.0, false, false);
    }
    EXPECT_NEAR(watch.worked_s(), 600.0, 20.0);
}

TEST(Rest, PunctureHidesTheNotice) {
    RestWatch watch(kRestAfter_s);
    EXPECT_TRUE(watch.update(1.0, true, false));
    EXPECT_TRUE(watch.shown());
    EXPECT_FALSE(watch.update(1.1, true, true));
    EXPECT_FALSE(watch.shown());
}

TEST(Rest, EarlierAttemptsCountSinceTheLastRest) {
    const std::array work{WorkPeriod{0.0, 400.0}, WorkPeriod{1000.0, 1300.0}, WorkPeriod{1360.0, 1500.0}};
    EXPECT_DOUBLE_EQ(sinceRest_s(work, 1550.0), 440.0);
    EXPECT_DOUBLE_EQ(sinceRest_s(work, 1500.0 + kRest_s), 0.0);
    EXPECT_DOUBLE_EQ(sinceRest_s({}, 5.0), 0.0);
}

TEST(Rest, NoticeIsShownWhenNoOtherIs) {
    FrameState seen;
    seen.tick.stage = haptics::ForceStage::on;
    seen.rest_due = true;
    ASSERT_TRUE(makeNotice(seen, Attention::focused, "press Enter"));
    EXPECT_NE(makeNotice(seen, Attention::focused, "")->title.find("rest"), std::string::npos);
    seen.paused_by_instructor = true;
    EXPECT_EQ(makeNotice(seen, Attention::focused, "")->title, "Paused");
}

}  // namespace
}  // namespace stylet::trainer
