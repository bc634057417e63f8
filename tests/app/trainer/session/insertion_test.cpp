#include "app/trainer/session/insertion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

using haptics::NeedleEventKind;
using haptics::Phase;
using patient::Tissue;

class InsertionLogTest : public testing::Test {
  protected:
    void tick(double depth_m, double force_n, Phase phase = Phase::pass) {
        haptics::TickOutput tick;
        tick.tick = ++ticks_;
        tick.phase = phase;
        tick.depth_m = depth_m, tick.force_n = force_n;
        log_.update(tick);
    }
    void passes(Tissue tissue, double depth_m, double cut_n, std::uint8_t label = 0) {
        haptics::NeedleEvent event;
        event.kind = cut_n > 0.0 ? NeedleEventKind::puncture : NeedleEventKind::entry;
        event.border.to = tissue, event.border.to_label = label;
        event.border.depth_m = depth_m, event.force_before_n = cut_n;
        log_.update(event);
    }
    std::vector<std::string> names() const {
        std::vector<std::string> names;
        for (const Passed& passed : log_.insertion().passed)
            names.push_back(passed.name);
        return names;
    }
    using Names = std::vector<std::string>;

    patient::Package package_ = test::ductPhantom();
    patient::Patient patient_{package_};
    InsertionLog log_{patient_};
    std::uint64_t ticks_ = 0;
};

TEST_F(InsertionLogTest, ListsTissuesInOrderOfDepth) {
    tick(0.001, 0.8, Phase::tenting);
    tick(0.003, 1.4, Phase::tenting);
    EXPECT_TRUE(log_.insertion().passed.empty()) << "the skin holds";
    passes(Tissue::skin, 0.0, 1.5);
    tick(0.0035, 0.2);
    passes(Tissue::soft, 0.002, 0.0);
    tick(0.020, 0.4);
    passes(Tissue::fascia, 0.020, 2.2);
    EXPECT_EQ(names(), (Names{"skin", "soft", "fascia"}));
    EXPECT_DOUBLE_EQ(log_.insertion().passed[2].depth_m, 0.020);
    EXPECT_DOUBLE_EQ(log_.insertion().passed[2].cut_n, 2.2);
    EXPECT_FLOAT_EQ(log_.insertion().felt.front().force_n, 0.8f) << "what was felt before the skin gave way";
}

TEST_F(InsertionLogTest, TentedBorderIsNotListed) {
    tick(0.001, 0.5);
    haptics::NeedleEvent met;
    met.kind = NeedleEventKind::border, met.border.to = Tissue::fascia;
    log_.update(met);
    EXPECT_TRUE(log_.insertion().passed.empty());
}

TEST_F(InsertionLogTest, SecondAdvanceReplacesTheFirst) {
    tick(0.001, 0.5);
    passes(Tissue::skin, 0.0, 1.0), passes(Tissue::soft, 0.002, 0.0), passes(Tissue::vessel, 0.030, 0.4);
    tick(0.031, 0.5), tick(0.010, -0.3);
    EXPECT_EQ(names(), (Names{"skin", "soft", "vessel"}));
    passes(Tissue::liver, 0.025, 0.6);
    EXPECT_EQ(names(), (Names{"skin", "soft", "liver"}));
    EXPECT_FLOAT_EQ(log_.insertion().felt.back().depth_m, 0.031f) << "the deepest stays the deepest";
}

TEST_F(InsertionLogTest, LastInsertionStaysUntilTheNextSkinPuncture) {
    tick(0.001, 0.5);
    passes(Tissue::skin, 0.0, 1.0), passes(Tissue::soft, 0.002, 0.0);
    tick(0.0, 0.0, Phase::outside);
    EXPECT_EQ(names().size(), 2u);
    tick(0.002, 0.5, Phase::tenting);
    EXPECT_EQ(names().size(), 2u) << "touched, not entered";
    passes(Tissue::skin, 0.0, 1.1);
    EXPECT_EQ(names(), (Names{"skin"}));
    ASSERT_EQ(log_.insertion().felt.size(), 1u);
    EXPECT_FLOAT_EQ(log_.insertion().felt[0].depth_m, 0.002f);
}

TEST_F(InsertionLogTest, SizeIsBounded) {
    tick(0.0001, 0.1);
    for (int i = 0; i < 500; ++i) {
        passes(i % 2 ? Tissue::soft : Tissue::vessel, 1e-4 * i, 0.1);
        for (int j = 0; j < 20; ++j)
            tick(1e-4 * i + 1e-6 * j, 0.5);
    }
    tick(10.0, 1.0);
    EXPECT_LE(log_.insertion().passed.size(), InsertionLog::kMaxPassed);
    EXPECT_LE(double(log_.insertion().felt.size()), InsertionLog::kDeepest_m / InsertionLog::kStep_m + 1.0);
    EXPECT_LT(log_.insertion().felt.back().depth_m, 0.06f) << "a depth beyond belief is not kept";
}

// A whole attempt on layers with known borders.
TEST(Insertion, FindsTheBordersOfALayeredPhantom) {
    const patient::Package package = test::ductPhantom();
    const test::Played played = test::playFast(package, test::shortScenario(), 1);
    ASSERT_FALSE(played.log.captures.empty());
    const Insertion* last = nullptr;
    for (const Capture& capture : played.log.captures)
        if (!capture.state.insertion.passed.empty()) last = &capture.state.insertion;
    ASSERT_NE(last, nullptr);
    for (const Passed& passed : last->passed) {
        double nearest_m = 1.0;
        for (const double border_m : {0.0, 0.002, 0.020, 0.022, 0.050, 0.056})
            nearest_m = std::min(nearest_m, std::fabs(passed.depth_m - border_m));
        EXPECT_LT(nearest_m, 0.0015) << passed.name << " at " << passed.depth_m;
    }
    EXPECT_EQ(last->passed.front().name, "skin");
}

}  // namespace
}  // namespace stylet::trainer
