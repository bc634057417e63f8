#include "haptics/tools/incision.h"

#include <gtest/gtest.h>

#include "tests/haptics/column.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using test::Hand;

TEST(Incision, IsOpenAlongItsLengthAndNotBeyond) {
    Incisions cuts;
    EXPECT_FALSE(isOpen(cuts, Vec3(0.0), 1.0));
    cuts.count = 1;
    cuts.list[0] = {{0.0, 0.0, 0.0}, {0.0, 0.006, 0.0}};
    EXPECT_TRUE(isOpen(cuts, {0.0014, 0.003, 0.0}, 0.0015));
    EXPECT_FALSE(isOpen(cuts, {0.0016, 0.003, 0.0}, 0.0015));
    EXPECT_TRUE(isOpen(cuts, {0.0, 0.0074, 0.0}, 0.0015));
    EXPECT_FALSE(isOpen(cuts, {0.0, 0.0076, 0.0}, 0.0015));
    EXPECT_FALSE(isOpen(cuts, {0.0, -0.0016, 0.0}, 0.0015));
    cuts.list[0].end_reference_m = cuts.list[0].begin_reference_m;  // a stab
    EXPECT_TRUE(isOpen(cuts, {0.0, 0.0014, 0.0}, 0.0015));
}

// At 0.5 mm depth: without an incision the skin tents. Through an incision, friction builds up from 0.
class IncisedSkin : public testing::Test {
  protected:
    Hand approach(double y_m, double cut_at_x_m = 0.0) {
        Hand hand(patient_);
        hand.incisions.count = 1;
        hand.incisions.list[0] = {{cut_at_x_m, -0.003, 0.0}, {cut_at_x_m, 0.003, 0.0}};
        hand.to({-0.005, y_m, 0.0});
        return hand;
    }
    const patient::Package package_ =
        test::makeColumn({{skin, 0.002}, {soft, 0.02}, {fascia, 0.003}, {liver, 0.02}});
    const patient::Patient patient_{package_};
};

TEST_F(IncisedSkin, IsEnteredWithoutPuncture) {
    Hand hand = approach(0.0);
    hand.sweep(0.0005);
    EXPECT_EQ(hand.state.phase, Phase::pass);
    EXPECT_EQ(hand.state.tissue, skin);
    EXPECT_NEAR(hand.force(), 800.0 * 0.0005, 1e-9);
    EXPECT_TRUE(hand.eventsOf(NeedleEventKind::border).empty());
    hand.sweep(0.010);
    EXPECT_NEAR(hand.force(), 0.7, 1e-9);
    hand.sweep(0.023);
    EXPECT_EQ(hand.state.phase, Phase::tenting);  // the fascia is intact
}

TEST_F(IncisedSkin, TentsBesideTheCutAndBeyondItsEnd) {
    for (const double y_m : {0.0046, -0.0046, 0.02}) {
        Hand hand = approach(y_m);
        hand.sweep(0.0005);
        EXPECT_EQ(hand.state.phase, Phase::tenting) << y_m;
        hand.sweep(0.001);
        EXPECT_EQ(hand.eventsOf(NeedleEventKind::puncture).size(), 1u) << y_m;
    }
}

TEST_F(IncisedSkin, DoesNotOpenDeeperBorders) {
    Hand hand = approach(0.0, 0.022);  // a cut that lies on the fascia
    hand.sweep(0.0005);
    EXPECT_EQ(hand.state.phase, Phase::tenting);
    hand.sweep(0.023);
    EXPECT_EQ(hand.state.tenting.border.to, fascia);
}

// Where the rim of skin voxels has a gap, the surface is fat. An incision opens it as well.
TEST(IncisedSurface, IsOpenWithoutASkinVoxel) {
    const patient::Package package = test::makeColumn({{soft, 0.02}});
    const patient::Patient patient(package);
    Hand hand(patient);
    hand.incisions.count = 1;
    hand.to(-0.005);
    hand.sweep(0.0004);
    EXPECT_NEAR(hand.force(), 0.4, 1e-9);
    EXPECT_EQ(hand.state.phase, Phase::pass);
}

// An incision is fixed to the tissue. Breathing moves it by 6 mm here.
TEST(IncisedSkinBreathing, IncisionMovesWithBreathing) {
    patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.02}});
    test::addBreathing(package, -0.010);
    const patient::Patient patient(package);
    for (const auto& [z_m, phase] : {std::pair{0.0, Phase::tenting}, std::pair{-0.006, Phase::pass}}) {
        Hand hand(patient);
        hand.incisions.count = 1;
        hand.incisions.list[0] = {{0.0, -0.003, 0.0}, {0.0, 0.003, 0.0}};
        hand.breath = {0.6, 0.0};
        hand.to({-0.005, 0.0, z_m});
        hand.sweep(0.0005);
        EXPECT_EQ(hand.state.phase, phase) << z_m;
    }
}

}  // namespace
}  // namespace stylet::haptics
