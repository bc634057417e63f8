#include "app/trainer/session/wounds.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace stylet::trainer {
namespace {

using haptics::NeedleEventKind;
using haptics::Phase;
using haptics::TickOutput;

class WoundsTest : public testing::Test {
  protected:
    // Runs `times` ticks with the needle at this point of the tissue.
    void tick(Phase phase, const Vec3& tip = {}, int times = 1,
              patient::Tissue tissue = patient::Tissue::soft) {
        for (int i = 0; i < times; ++i) {
            TickOutput now;
            now.tick = tick_++;
            now.phase = phase;
            now.tissue = tissue;
            now.tip_reference_m = tip;
            log_.update(now);
        }
    }
    void cut(patient::Tissue into) {
        haptics::NeedleEvent event;
        event.kind = NeedleEventKind::puncture;
        event.border.to = into;
        log_.update(event);
    }
    std::vector<Wound> of(WoundKind kind) const {
        std::vector<Wound> found = log_.wounds();
        std::erase_if(found, [&](const Wound& w) { return w.kind != kind; });
        return found;
    }

    WoundLog log_{0.001};
    std::uint64_t tick_ = 0;
};

TEST_F(WoundsTest, OneHolePerEntryPoint) {
    tick(Phase::outside);
    EXPECT_FALSE(log_.bleed()) << "of what?";
    EXPECT_TRUE(log_.wounds().empty());
    tick(Phase::tenting, Vec3(0.1, 0, 0));
    tick(Phase::pass, Vec3(0.05, 0, 0), 50);
    tick(Phase::outside);
    tick(Phase::tenting, Vec3(0.1005, 0, 0));  // the same hole again
    tick(Phase::outside);
    ASSERT_EQ(of(WoundKind::puncture).size(), 1u);
    EXPECT_EQ(of(WoundKind::puncture)[0].reference_m, Vec3(0.1, 0, 0));
    tick(Phase::tenting, Vec3(0.12, 0, 0));
    EXPECT_EQ(of(WoundKind::puncture).size(), 2u);
    EXPECT_TRUE(of(WoundKind::blood).empty());
}

TEST_F(WoundsTest, AThinNeedleLeavesASmallHole) {
    tick(Phase::pass, Vec3(0.1, 0, 0));
    tick(Phase::outside);
    log_.setNeedleRadius(0.00036);
    tick(Phase::pass, Vec3(0.12, 0, 0));
    const std::vector<Wound> holes = of(WoundKind::puncture);
    ASSERT_EQ(holes.size(), 2u);
    EXPECT_DOUBLE_EQ(holes[0].size_m, 0.00075);
    EXPECT_DOUBLE_EQ(holes[1].size_m, 0.00036);
}

TEST_F(WoundsTest, PressedSkinHasNoHole) {
    tick(Phase::tenting, Vec3(0.1, 0, 0), 100, patient::Tissue::air);
    tick(Phase::outside);
    EXPECT_TRUE(log_.wounds().empty());
    tick(Phase::tenting, Vec3(0.1, 0, 0), 10, patient::Tissue::air);
    tick(Phase::tenting, Vec3(0.1, 0, 0), 10, patient::Tissue::skin);  // tenting at the next border
    EXPECT_EQ(of(WoundKind::puncture).size(), 1u);
    EXPECT_TRUE(log_.bleed());
    EXPECT_EQ(of(WoundKind::blood).size(), 1u);
}

TEST_F(WoundsTest, OldestHoleIsDroppedFirst) {
    for (int i = 0; i < 9; ++i) {
        tick(Phase::pass, Vec3(0.01 * i, 0, 0));
        tick(Phase::outside);
    }
    const std::vector<Wound> holes = of(WoundKind::puncture);
    EXPECT_EQ(holes.size(), 6u);
    EXPECT_EQ(holes.back().reference_m, Vec3(0.08, 0, 0));
    tick(Phase::pass, Vec3(0.05, 0, 0));
    cut(patient::Tissue::vessel);
    EXPECT_EQ(of(WoundKind::blood).at(0).reference_m, Vec3(0.05, 0, 0));
}

TEST_F(WoundsTest, VesselCutBleedsFromTheNewestHoleWithDecreasingRate) {
    tick(Phase::tenting, Vec3(0.1, 0, 0));
    tick(Phase::outside);
    tick(Phase::tenting, Vec3(0.12, 0, 0));
    cut(patient::Tissue::liver);
    EXPECT_TRUE(of(WoundKind::blood).empty());
    cut(patient::Tissue::vessel);
    const auto radiusAfter = [&](int ticks) {
        tick(Phase::pass, Vec3(0.12, 0, 0), ticks);
        return of(WoundKind::blood).at(0).size_m;
    };
    const double begin = radiusAfter(1), second = radiusAfter(1000), third = radiusAfter(1000);
    EXPECT_EQ(of(WoundKind::blood).size(), 1u);
    EXPECT_EQ(of(WoundKind::blood)[0].reference_m, Vec3(0.12, 0, 0));
    EXPECT_GT(begin, 0.001);
    EXPECT_GT(second, begin);
    EXPECT_GT(third, second);
    EXPECT_LT(third - second, second - begin);
    cut(patient::Tissue::vessel);  // the hole already bleeds
    EXPECT_GE(radiusAfter(1), third);
    EXPECT_LE(radiusAfter(200000), 0.0201);
}

TEST_F(WoundsTest, AnIncisionGrowsUntilTheNextBegins) {
    TickOutput now;
    now.tool = haptics::Tool::scalpel;
    const auto cutTo = [&](int count, double x) {
        now.tick = tick_++;
        now.incision_count = count;
        now.newest_incision = {Vec3(0.0, 0.1 * count, 0.0), Vec3(x, 0.1 * count, 0.0)};
        log_.update(now);
    };
    cutTo(1, 0.0);
    EXPECT_TRUE(of(WoundKind::incision).empty()) << "a point is not a cut yet";
    cutTo(1, 0.002);
    cutTo(1, 0.004);
    cutTo(2, 0.006);
    const std::vector<Wound> cuts = of(WoundKind::incision);
    ASSERT_EQ(cuts.size(), 2u);
    EXPECT_DOUBLE_EQ(cuts[0].size_m, 0.002);
    EXPECT_EQ(cuts[0].reference_m, Vec3(0.002, 0.1, 0.0));
    EXPECT_DOUBLE_EQ(cuts[1].size_m, 0.003);
    EXPECT_EQ(cuts[1].along, Vec3(1, 0, 0));
}

}  // namespace
}  // namespace stylet::trainer
