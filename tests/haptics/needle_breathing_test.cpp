// Breathing under the needle: breathing affects forces only through the position of the channel point.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics/tools/needle.h"
#include "tests/haptics/column.h"
#include "tests/support/motion.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using patient::Surrogate;
using test::Hand;

// Layers along x that move along z with the breath.
struct Breathing {
    explicit Breathing(double travel_m) {
        package = test::makeColumn({{skin, 0.002}, {soft, 0.010}, {liver, 0.040}});
        test::addBreathing(package, travel_m);
    }
    patient::Package package;
};

// Breathes for 4 s at 1 kHz, from end-exhale to end-exhale.
template <typename PerTick>
void breathe(Hand& hand, const PerTick& perTick) {
    patient::BreathingState state;
    const patient::BreathPlan plan{.rhythm = hand.patient.package().signal};
    for (int i = 0; i < 4000; ++i) {
        patient::stepBreathing(state, plan, 0.001);
        hand.breath = patient::surrogateAt(state, plan, 0.001);
        hand.to(hand.state.tip_deformed_m);
        perTick();
    }
}

TEST(NeedleBreathing, AStillHandFeelsTheBreathAlongItsNeedle) {
    const Breathing b(-0.004);
    const patient::Patient patient(b.package);
    Hand hand(patient);
    hand.axis = Vec3(std::sqrt(0.75), 0.0, 0.5);  // 30 degrees up: half of the motion is axial
    for (int i = 0; i <= 300; ++i)
        hand.to(Vec3(-0.004, 0.0, 0.0) + hand.axis * (0.0001 * i));
    ASSERT_EQ(hand.state.tissue, liver);
    double lowest = hand.force(), highest = hand.force(), deepest = hand.state.depth_m;
    const double began_n = hand.force(), began_m = hand.state.depth_m;
    breathe(hand, [&] {
        lowest = std::min(lowest, hand.force());
        highest = std::max(highest, hand.force());
        deepest = std::max(deepest, hand.state.depth_m);
    });
    EXPECT_NEAR(began_n, 0.9, 1e-9);
    // The liver moves down by 4 mm, 2 mm of it against the needle. The needle goes deeper, then back.
    EXPECT_NEAR(deepest - began_m, 0.002, 1e-5);
    EXPECT_NEAR(hand.state.depth_m, began_m, 1e-5);
    EXPECT_NEAR(highest, 0.9, 1e-9);
    EXPECT_NEAR(lowest, -0.9, 1e-9);  // retracted relative to the tissue on the way back
}

TEST(NeedleBreathing, AStillHandInAStillPatientFeelsNoChange) {
    const Breathing b(0.0);
    const patient::Patient patient(b.package);
    Hand hand(patient);
    hand.to(-0.004);
    hand.sweep(0.020);
    const double began_n = hand.force();
    const Vec3 channel = hand.state.channel_reference_m;
    breathe(hand, [&] { ASSERT_EQ(hand.force(), began_n); });
    EXPECT_EQ(hand.state.channel_reference_m, channel);
}

TEST(NeedleBreathing, ChannelDoesNotDriftDuringABreathHold) {
    const Breathing b(-0.015);
    const patient::Patient patient(b.package);
    Hand hand(patient);
    hand.breath = {0.7, 0.0};
    hand.to(-0.004);
    hand.sweep(0.020);
    hand.to(hand.state.tip_deformed_m);
    const Vec3 channel = hand.state.channel_reference_m;
    const double began_n = hand.force();
    for (int i = 0; i < 20000; ++i)
        hand.to(hand.state.tip_deformed_m);
    const Vec3 d = hand.state.channel_reference_m - channel;
    EXPECT_LT(std::sqrt(glm::dot(d, d)), 1e-9);
    EXPECT_EQ(hand.force(), began_n);
}

TEST(NeedleBreathing, SlidingLiverIsCutSideways) {
    const Breathing b(-0.015);
    const patient::Patient patient(b.package);
    Hand hand(patient);
    hand.to(-0.004);
    hand.sweep(0.020);  // perpendicular to the breathing motion
    double most_n = 0.0;
    breathe(hand, [&] {
        const Vec3 f = needleForce(hand.state, hand.settings, hand.axis);
        most_n = std::max(most_n, std::sqrt(f.y * f.y + f.z * f.z));
        // The tissue under the tip is within the lateral spring's reach.
        const Vec3 back =
            patient::deformedFromReference(b.package.motion, hand.breath, hand.state.channel_reference_m);
        const Vec3 off = hand.state.tip_deformed_m - back;
        ASSERT_LE(std::sqrt(glm::dot(off, off)), 0.5 / 150.0 + 1e-5);
    });
    EXPECT_NEAR(most_n, 0.5, 1e-9);
    // 15 mm in one direction less the reach, then back across the reach to the other side.
    const double reach = 0.5 / 150.0;
    EXPECT_NEAR(hand.state.lateral_cut_m, (0.015 - reach) + (0.015 - 2.0 * reach), 1e-4);
}

// The channel point uses a first-order approximation of the motion field around its last evaluation.
// Neither position nor depth may drift from the exact values.
TEST(NeedleBreathing, ChannelKeepsItsReferencePositionInABendingField) {
    Breathing b(0.0);
    b.package.motion = test::makeBending();
    const patient::MotionModel& motion = b.package.motion;
    const patient::Patient patient(b.package);
    Hand hand(patient);
    patient::BreathingState breathing;
    const patient::BreathPlan plan{};
    double tip_m = -0.004, depth_m = 0.0, worst_m = 0.0;
    const NeedleState& s = hand.state;
    hand.to(tip_m);
    for (int tick = 0; tick < 12000; ++tick) {
        // Inserts, then moves between 5 and 35 mm at 20 mm/s, for three breaths.
        const bool in = tick < 1950 || (tick - 1950) / 1500 % 2 == 1;
        tip_m += in ? 20e-6 : -20e-6;
        const Vec3 before = s.tip_deformed_m - s.lateral_m;
        const Vec3 tissue = s.channel_reference_m;
        const patient::Side side = s.channel_side;
        const Surrogate breath = hand.breath;
        const bool embedded = s.phase != Phase::outside;
        const double was_m = s.depth_m;
        patient::stepBreathing(breathing, plan, 0.001);
        hand.breath = patient::surrogateAt(breathing, plan, 0.001);
        hand.to(tip_m);
        if (!embedded) continue;
        const Vec3 carried = patient::deformedFromReference(motion, hand.breath, side, tissue) -
                             patient::deformedFromReference(motion, breath, side, tissue);
        depth_m += glm::dot(Vec3(tip_m, 0.0003, 0.0002) - before - carried, hand.axis) - (s.depth_m - was_m);
        const Vec3 off =
            patient::deformedFromReference(motion, hand.breath, s.channel_side, s.channel_reference_m) -
            (s.tip_deformed_m - s.lateral_m);
        worst_m = std::max(worst_m, std::sqrt(glm::dot(off, off)));
    }
    EXPECT_NE(s.phase, Phase::outside);
    EXPECT_LT(worst_m, 5e-6);
    EXPECT_LT(std::fabs(depth_m), 10e-6);
    EXPECT_GT(s.lateral_cut_m, 0.005);
}

// At the cavity's surface, x = 10 mm, the inside has slid by 15 mm. In the reference frame the path jumps
// from z = 0 to z = 15 mm across a rib. The needle must not meet that rib.
TEST(NeedleBreathing, TissueBetweenSlidSidesIsNotOnThePath) {
    Breathing b(-0.015);
    b.package.motion = test::makeMotion(Vec3(0.3), 0.1, [](const Vec3& p) {
        test::MotionPoint q;
        q.slide_a1_m.z = -0.015;
        q.level_m = 0.010 - p.x;
        return q;
    });
    b.package = test::repeatColumn(b.package, 80, 0.001);
    LabelVolume& labels = b.package.labels;
    for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
        const int nx = labels.grid.dims.x, ny = labels.grid.dims.y;
        const Vec3 p = labels.grid.centre({int(i) % nx, int(i) / nx % ny, int(i) / nx / ny});
        if (p.x > 0.006 && p.x < 0.014 && p.z > 0.004 && p.z < 0.011) labels.voxels[i] = std::uint8_t(bone);
    }
    const patient::Patient patient(b.package);
    ASSERT_EQ(patient.at(Vec3(0.010, 0.0, 0.008), {}).tissue, bone);
    Hand hand(patient);
    hand.breath = {1.0, 0.0};
    hand.to(-0.004);
    hand.sweep(0.030);
    EXPECT_NEAR(hand.state.channel_reference_m.z, 0.0152, 1e-6);
    EXPECT_NEAR(hand.state.depth_m, 0.030, 1e-6);
    EXPECT_NEAR(hand.force(), 0.9, 1e-9);
    for (const NeedleEvent& e : hand.events)
        EXPECT_NE(e.border.to, bone);
}

// Fitted fields leave gaps and overlaps of fractions of a millimetre where the sides meet. A needle that
// moves slowly through one is on exactly one side in every tick, and stays in its channel.
TEST(NeedleBreathing, AGapOrAnOverlapOfTheSidesIsCrossedLikeAnyTissue) {
    for (const double off_m : {-0.0004, 0.0004}) {
        Breathing b(-0.015);
        b.package.motion = test::makeMotion(Vec3(0.3), 0.1, [&](const Vec3& p) {
            test::MotionPoint q;
            q.slide_a1_m = Vec3(off_m, 0.0, -0.015);
            q.level_m = 0.020 - p.x;
            return q;
        });
        b.package = test::repeatColumn(b.package, 80, 0.001);
        const patient::Patient patient(b.package);
        Hand hand(patient);
        hand.breath = {1.0, 0.0};
        hand.to(-0.004);
        for (int i = 0; i <= 3400; ++i) {
            hand.to(Vec3(-0.004 + 1e-5 * i, 0.0, 0.0));
            ASSERT_LT(std::sqrt(glm::dot(hand.state.lateral_m, hand.state.lateral_m)), 1e-6) << i;
        }
        EXPECT_NEAR(hand.state.channel_reference_m.z, 0.015, 1e-6);
        EXPECT_NEAR(hand.state.channel_reference_m.x, 0.030 - off_m, 1e-6);
        EXPECT_NEAR(hand.state.depth_m, 0.030, 1e-6);
        EXPECT_EQ(hand.state.lateral_cut_m, 0.0);
        EXPECT_NEAR(hand.force(), 0.9, 1e-9);
        // Also while breathing with the needle in the gap: the offset stays within the spring's reach.
        breathe(hand, [&] {
            ASSERT_LE(std::sqrt(glm::dot(hand.state.lateral_m, hand.state.lateral_m)), 0.5 / 150.0 + 1e-9);
        });
    }
}

// A hole is fixed to the tissue. Here it moves with the breath, perpendicular to the needle.
TEST(NeedleBreathing, CutBordersMoveWithBreathing) {
    const Breathing b(-0.010);
    const patient::Patient patient(b.package);
    const auto cutsAt = [&](double v, double z_m) {
        Hand hand(patient);
        hand.to(-0.004);
        hand.sweep(0.020);
        hand.sweep(-0.004);
        hand.breath = {v, 0.0};
        hand.to({-0.004, 0.0003, z_m});
        hand.events.clear();
        hand.sweep(0.020);
        return hand.eventsOf(NeedleEventKind::puncture).size();
    };
    EXPECT_EQ(cutsAt(0.0, 0.0002), 0u);           // the same hole
    EXPECT_EQ(cutsAt(0.6, 0.0002), 1u);           // the hole has moved 6 mm down
    EXPECT_EQ(cutsAt(0.6, 0.0002 - 0.006), 0u);   // at the moved hole
    EXPECT_EQ(cutsAt(0.6, 0.0002 - 0.0041), 1u);  // beside the moved hole
}

// The needle tents the liver's capsule (the table is changed so that it tents) along the breathing motion.
// The surface moves toward the tip and away from it.
TEST(NeedleBreathing, TentingSurfaceMovesWithBreathing) {
    Breathing b(0.004);
    b.package.tissues[std::size_t(liver)].cut_force_n = 2.0;
    b.package = test::repeatColumn(b.package, 120, 0.001);
    for (std::size_t i = 0; i < b.package.labels.voxels.size(); ++i) {
        // Layers along z instead: soft tissue, then liver above z = 0.
        const Grid& g = b.package.labels.grid;
        const int z = int(i) / (g.dims.x * g.dims.y);
        b.package.labels.voxels[i] = std::uint8_t(g.centre({0, 0, z}).z > 0.0 ? liver : soft);
    }
    const patient::Patient patient(b.package);
    Hand hand(patient);
    hand.axis = {0.0, 0.0, 1.0};
    hand.breath = {0.5, 0.0};
    hand.to({0.020, 0.0, -0.065});
    for (int i = 0; i <= 680; ++i)
        hand.to({0.020, 0.0, -0.065 + 0.0001 * i});
    // The surface has moved up by half of 4 mm. The tip is 1 mm behind it.
    ASSERT_EQ(hand.state.phase, Phase::tenting);
    const double behind_m = hand.state.tenting.depth_m, k = 1200.0, rise_n = 2.0 - 0.7;
    ASSERT_NEAR(behind_m, 0.001, 2e-5);
    const auto curve = [&](double d) { return 0.7 + 0.5 * k * d + 0.5 * k * k / rise_n * d * d; };
    const Vec3 tip = hand.state.tip_deformed_m;
    hand.breath = {0.6, 0.0};  // the surface moves 0.4 mm up, away from the tip
    hand.to(tip);
    EXPECT_NEAR(hand.state.tenting.depth_m, behind_m - 0.0004, 2e-5);
    EXPECT_NEAR(hand.force(), curve(hand.state.tenting.depth_m), 1e-9);
    EXPECT_NEAR(hand.last.tissue_moved_m.z, 0.0004, 2e-5);
    hand.breath = {0.4, 0.0};  // and back down
    hand.to(tip);
    EXPECT_EQ(hand.eventsOf(NeedleEventKind::puncture).size(), 2u);  // soft tissue and liver
    EXPECT_NEAR(hand.last.tissue_moved_m.z, -0.0008, 2e-5);
    hand.to(tip);
    EXPECT_EQ(hand.last.tissue_moved_m, Vec3(0.0));
}

TEST(NeedleBreathing, BreathingPushesTheSurfaceOntoAStillNeedle) {
    const Breathing b(0.0);
    patient::Package package = b.package;
    test::addBreathing(package, 0.004);
    const patient::Patient patient(package);
    // The needle is above the column's end face at z = 40 mm and points down. The liver moves up onto the
    // needle and away again.
    Hand hand(patient);
    hand.axis = {0.0, 0.0, -1.0};
    hand.to({0.030, 0.0, 0.0401});
    ASSERT_EQ(hand.state.phase, Phase::outside);
    double most_n = 0.0;
    breathe(hand, [&] { most_n = std::max(most_n, hand.force()); });
    EXPECT_GT(most_n, 0.3 - 0.01);  // the liver's threshold, reached by breathing alone
}

}  // namespace
}  // namespace stylet::haptics
