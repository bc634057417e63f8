// Rules of the model's section 3, one by one, as far as needle_test.cpp does not cover them.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics/tools/exact.h"
#include "tests/haptics/puncture.h"
#include "tests/haptics/random_column.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using test::Hand;
using test::kTorso;
using test::Puncture;

TEST(NeedleRules, SustainedForceIsBitwiseConstant) {
    Puncture p(kTorso);
    p.hand.sweep(0.031);
    const double force_n = p.hand.force();
    EXPECT_EQ(p.hand.state.extension_m, 0.9 / 1200.0);
    for (int i = 0; i < 2000; ++i) {
        p.hand.to(0.031 + 0.00001 * i);
        ASSERT_EQ(p.hand.force(), force_n);
    }
}

TEST(NeedleRules, OneTickThroughTheWholeTorsoReportsEveryBorder) {
    Puncture leap(kTorso), creep(kTorso);
    leap.hand.to(0.065);
    creep.hand.sweep(0.065, 0.00001);
    ASSERT_EQ(leap.hand.events.size(), creep.hand.events.size());
    for (std::size_t i = 0; i < leap.hand.events.size(); ++i) {
        EXPECT_EQ(leap.hand.events[i].kind, creep.hand.events[i].kind);
        EXPECT_NEAR(leap.hand.events[i].tenting_m, creep.hand.events[i].tenting_m, 1e-9);
        EXPECT_NEAR(leap.hand.events[i].force_after_n, creep.hand.events[i].force_after_n, 1e-9);
    }
    EXPECT_NEAR(leap.hand.force(), creep.hand.force(), 1e-9);
}

// Duct 0.5 N -> liver 0.9 N: (0.9 - 0.5) / 1.2 = 0.333 mm.
TEST(NeedleRules, ForceRisesGraduallyWithoutTenting) {
    Puncture p(kTorso);
    p.hand.sweep(0.059 - 1e-6);
    ASSERT_NEAR(p.hand.force(), 0.5, 1e-9);
    p.hand.sweep(0.059 + 0.0001);
    EXPECT_EQ(p.hand.state.tissue, liver);
    EXPECT_NEAR(p.hand.force(), 0.5 + 0.12, 1e-9);
    p.hand.sweep(0.059 + 0.4 / 1200.0 - 1e-6);
    EXPECT_LT(p.hand.force(), 0.9);
    p.hand.sweep(0.059 + 0.4 / 1200.0 + 1e-6);
    EXPECT_NEAR(p.hand.force(), 0.9, 1e-9);
}

// The needle clips a corner without puncturing it. When it advances into the corner again with a negative
// force, tenting starts at that force.
TEST(NeedleRules, TentingStartsFromANegativeForce) {
    Puncture p({{skin, 0.002}, {liver, 0.02}, {duct, 0.0002}, {liver, 0.02}});
    p.hand.sweep(0.030);
    p.hand.sweep(0.02195);
    ASSERT_NEAR(p.hand.force(), -0.5 - 0.06, 1e-9);  // the duct's friction, then 0.05 mm of liver
    p.hand.sweep(0.0221);
    ASSERT_EQ(p.hand.state.phase, Phase::tenting);
    const double a0 = -0.5, a2 = 1000.0 * 500.0 / (1.2 - a0);
    EXPECT_NEAR(p.hand.state.tenting.a0_n, a0, 1e-9);
    EXPECT_NEAR(p.hand.force(), a0 + 500.0 * 0.0001 + a2 * 1e-8, 1e-9);
    p.hand.sweep(0.0223);
    const double far_n = a0 + 500.0 * 0.0002 + a2 * 4e-8;
    EXPECT_NEAR(p.hand.events[p.hand.events.size() - 2].force_before_n, far_n, 1e-9);
    EXPECT_NEAR(p.hand.force(), far_n + 0.12, 1e-9);
}

TEST(NeedleRules, EveryShareOfA1FollowsItsCurve) {
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        Puncture p(kTorso);
        p.hand.settings.a1_share = share;
        const double border_m = 0.022, cut_m = 0.0018, a0 = 0.7, t = 2.5;
        p.hand.sweep(border_m);
        EXPECT_NEAR(p.hand.force(), a0, 1e-9);
        for (const double part : {0.1, 0.25, 0.5, 0.9}) {
            p.hand.sweep(border_m + part * cut_m);
            EXPECT_NEAR(p.hand.force(), a0 + (t - a0) * ((1.0 - share) * part * part + share * part), 1e-9);
        }
        const double h = 1e-7;
        p.hand.to(border_m + cut_m - 2.0 * h);
        const double below_n = p.hand.force();
        p.hand.to(border_m + cut_m - h);
        EXPECT_NEAR((p.hand.force() - below_n) / h, (2.0 - share) * 1000.0, 0.5);
        p.hand.to(border_m + cut_m + h);
        EXPECT_NEAR(p.last().force_before_n, 2.5, 1e-9);
        EXPECT_NEAR(p.last().tenting_m, cut_m, 1e-12);
    }
}

TEST(NeedleRules, AirBehindAThinMembraneIsEnteredAtItsPuncture) {
    Puncture p({{skin, 0.002}, {soft, 0.02}, {fascia, 0.0002}, {air, 0.01}, {soft, 0.01}});
    p.hand.sweep(0.0238 - 1e-6);
    EXPECT_EQ(p.hand.state.phase, Phase::tenting);
    EXPECT_NEAR(p.hand.force(), 2.5, 0.01);
    p.hand.sweep(0.0238 + 1e-6);
    EXPECT_EQ(p.hand.force(), 0.0);
    EXPECT_EQ(p.hand.state.tissue, air);
    EXPECT_EQ(p.last().border.to, air);
    EXPECT_EQ(p.last().role, patient::Role::risk);
    EXPECT_NEAR(p.last().border.reference_m.x, 0.0222, 1e-9);
}

// Bone must not be queued behind a membrane, because it would be punctured together with the membrane.
TEST(NeedleRules, BoneIsNeverQueued) {
    Puncture p({{skin, 0.002}, {soft, 0.01}, {fascia, 0.0002}, {liver, 0.0003}, {bone, 0.01}});
    p.hand.sweep(0.0125 + 1e-6);
    ASSERT_EQ(p.hand.state.queued_count, 1);  // the liver
    const double there_n = p.hand.force();
    p.hand.sweep(0.0125 + 0.010);
    EXPECT_NEAR(p.hand.force(), there_n + 2000.0 * 0.010, 0.01);
    EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::puncture).size(), 1u);  // the skin's puncture
}

// On a subcostal path, only the liver proves that the fascia was passed. A contrast-filled vessel counts as
// bone before that proof and as soft tissue after it.
TEST(NeedleRules, EnteringTheLiverSetsTheFasciaFlagUntilWithdrawal) {
    patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.02}, {liver, 0.02}, {soft, 0.01}});
    for (int i = 430; i < 520; ++i) {
        package.labels[{i, 0, 0}] = 0;
        package.ct[{i, 0, 0}] = 250;  // between the sensitive and the specific threshold
    }
    const patient::Patient patient(package);
    Hand hand(patient);
    hand.to(-0.005);
    hand.sweep(0.030);
    EXPECT_TRUE(hand.state.track.past_fascia);
    hand.sweep(0.0475);
    EXPECT_EQ(hand.state.tissue, soft);
    hand.sweep(0.021);
    EXPECT_FALSE(hand.state.track.past_fascia);
    EXPECT_TRUE(hand.state.track.past_skin);
    EXPECT_EQ(patient.at(Vec3(0.045, 0.0, 0.0), hand.state.track).tissue, bone);
}

// The model says: "This only lowers the force at once". Tested for insertion and withdrawal, with random
// force tables.
TEST(NeedleRules, AChangeOfTissueOnlyLowersTheForce) {
    std::size_t changes = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        test::RandomColumn column(seed);
        Hand& hand = column.hand;
        test::Random& random = column.random;
        hand.to(-0.003);
        const double step_m = 0.00001;
        for (int leg = 0; leg < 6; ++leg) {
            const double goal_m = test::uniform(random, 0.004, 0.04);
            while (std::fabs(hand.state.tip_deformed_m.x - goal_m) > step_m) {
                const Tissue before = hand.state.tissue;
                const Phase phase = hand.state.phase;
                const double before_n = hand.force(), travel_m = goal_m - hand.state.tip_deformed_m.x;
                hand.events.clear();
                hand.to(hand.state.tip_deformed_m.x + std::copysign(step_m, travel_m));
                for (const NeedleEvent& e : hand.events)
                    ASSERT_LE(std::fabs(e.force_after_n), std::fabs(e.force_before_n) + 1e-9);
                if (hand.state.tissue == before || phase != Phase::pass || hand.state.phase != Phase::pass)
                    continue;
                ASSERT_LE(std::fabs(hand.force()), std::fabs(before_n) + 3000.0 * step_m) << seed;
                ++changes;
            }
        }
    }
    EXPECT_GT(changes, 2000u);
}

// ---- energy reported to the output stage

struct Ledger {
    double shortfall_j = 0.0;  // largest energy gain without a source in one tick
    double spent_j = 0.0;      // work of the hand that is not stored in a spring
};

// Compares the hand's work in one tick (trapezoidal rule) with the energy gained by the springs.
void account(Ledger& ledger, const ToolForce& before, const ToolForce& after, const Vec3& moved_m) {
    const Vec3 mean_n = 0.5 * (before.force_n + after.force_n);
    const double work_j = -glm::dot(mean_n, moved_m - after.tissue_moved_m);
    ledger.spent_j += work_j - (after.energy_j - before.energy_j);
    ledger.shortfall_j = std::max(ledger.shortfall_j, after.energy_j - before.energy_j - work_j);
}

TEST(NeedleEnergy, EqualsTheForceIntegralWhileTentingAndTheSpringEnergyInPass) {
    Puncture p(kTorso);
    p.hand.sweep(0.0005);
    const double a2 = 800.0 * 400.0 / 0.7;
    EXPECT_NEAR(axialEnergy(p.hand.state, p.hand.settings, p.patient),
                400.0 / 2.0 * 0.0005 * 0.0005 + a2 / 3.0 * 0.0005 * 0.0005 * 0.0005, 1e-12);
    p.hand.sweep(0.015);
    EXPECT_NEAR(axialEnergy(p.hand.state, p.hand.settings, p.patient), 0.7 * 0.7 / 2000.0, 1e-12);
    p.hand.to({0.015, 0.0003 + 0.002, 0.0002});
    EXPECT_NEAR(p.hand.last.energy_j, 0.7 * 0.7 / 2000.0 + 0.5 * 150.0 * 0.002 * 0.002, 1e-12);
    EXPECT_NEAR(p.hand.last.force_n.y, -0.3, 1e-9);
}

TEST(NeedleEnergy, KeepsRisingLinearlyAtMaximumForceOnBone) {
    Puncture p({{skin, 0.002}, {soft, 0.01}, {bone, 0.05}});
    p.hand.sweep(0.012);
    const double before_j = p.hand.last.energy_j;
    p.hand.sweep(0.012 + 0.020);
    const double rise_m = (22.0 - 0.7) / 2000.0;
    EXPECT_NEAR(p.hand.last.energy_j - before_j, 0.5 * (0.7 + 22.0) * rise_m + 22.0 * (0.020 - rise_m), 1e-9);
}

// Between events, the springs never gain more energy than the hand puts in, whatever its motion.
TEST(NeedleEnergy, IsPassiveBetweenEvents) {
    Ledger ledger;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        test::RandomColumn column(seed);
        Hand& hand = column.hand;
        test::Random& random = column.random;
        hand.settings.a1_share = test::uniform(random, 0.0, 1.0);
        Vec3 tip{-0.001, 0.0, 0.0};
        double speed_m = 0.0;
        hand.to(tip);
        for (int i = 0; i < 4000; ++i) {
            speed_m = std::clamp(speed_m + test::uniform(random, -2e-6, 2.2e-6), -2e-5, 2e-5);
            const Vec3 move{speed_m, test::uniform(random, -5e-6, 5e-6), test::uniform(random, -5e-6, 5e-6)};
            const ToolForce before = hand.last;
            tip += move;
            hand.to(tip);
            if (!hand.last.event) account(ledger, before, hand.last, move);
        }
    }
    // Error of the trapezoidal rule in the tick where clamping starts: k ds^2 / 2.
    EXPECT_LT(ledger.shortfall_j, 0.5 * 3000.0 * 2e-5 * 2e-5);
    EXPECT_GT(ledger.spent_j, 0.01);
}

TEST(NeedleEnergy, EveryForceStepIsFlaggedAsAnEvent) {
    std::size_t steps = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        test::RandomColumn column(seed);
        Hand& hand = column.hand;
        hand.to(-0.001);
        for (const double goal_m : {0.012, 0.006, 0.03, 0.01, 0.035, -0.004}) {
            const double step_m = 0.00002;
            while (std::fabs(goal_m - hand.state.tip_deformed_m.x) > step_m) {
                const double before_n = hand.force();
                hand.to(hand.state.tip_deformed_m.x +
                        std::copysign(step_m, goal_m - hand.state.tip_deformed_m.x));
                if (std::fabs(hand.force() - before_n) < 2.0 * 3000.0 * step_m + 1e-6) continue;
                ASSERT_TRUE(hand.last.event) << seed << " at " << hand.state.tip_deformed_m.x;
                ++steps;
            }
        }
    }
    EXPECT_GT(steps, 500u);
}

// The test above with oblique borders and arbitrary motion: borders are met, left, slid along and cut
// sideways.
TEST(NeedleEnergy, EveryForceStepIsFlaggedAsAnEventOnSlantedLayers) {
    std::size_t steps = 0, sideways = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        test::Random random(seed);
        patient::Package package =
            test::repeatColumn(test::makeColumn(test::randomLayers(random), 0.0005), 60, 0.0005);
        package.tissues = test::randomTable(random);
        const LabelVolume upright = package.labels;
        const double slant_y = test::uniform(random, -1.5, 1.5), slant_z = test::uniform(random, -1.5, 1.5);
        forEachVoxel(upright.grid, [&](const Index3& i) {
            const Vec3 p = upright.grid.centre(i);
            package.labels[i] = upright.nearestOr({p.x + slant_y * p.y + slant_z * p.z, p.y, p.z}, 0);
        });
        const patient::Patient patient(package);
        Hand hand(patient);
        hand.axis =
            glm::normalize(Vec3(1.0, test::uniform(random, -0.5, 0.5), test::uniform(random, -0.5, 0.5)));
        Vec3 tip{-0.015, 0.0, 0.0};
        hand.to(tip);
        const double step_m = 0.00002;
        for (int goal = 0; goal < 12; ++goal) {
            const Vec3 to{test::uniform(random, goal < 2 ? 0.015 : -0.005, 0.035),
                          test::uniform(random, -0.010, 0.010), test::uniform(random, -0.010, 0.010)};
            for (int n = int(glm::length(to - tip) / step_m); n > 0; --n) {
                const double before_n = hand.force();
                tip += (to - tip) / double(n);
                hand.to(tip);
                if (std::fabs(hand.force() - before_n) < 2.0 * 3000.0 * step_m + 1e-6) continue;
                ASSERT_TRUE(hand.last.event) << seed << " at " << tip.x << " " << tip.y << " " << tip.z;
                ++steps;
            }
        }
        sideways += hand.eventsOf(NeedleEventKind::sideways).size();
    }
    EXPECT_GT(steps, 300u);
    EXPECT_GT(sideways, 300u);
}

// ---- bone in the study

TEST(NeedleRules, StudyUsesTheMaximumForceAtBoneContact) {
    const std::vector<Segment> path{{0.0, air, 0}, {0.01, skin, 1}, {0.012, soft, 2}, {0.022, bone, 3}};
    const ExactForce e = solveExact(test::tissueDefaults().tissues, path, 0.03, {}, Bone::immediateMaximum);
    EXPECT_NEAR(e.at(0.022 - 1e-9), 0.7, 1e-9);
    EXPECT_EQ(e.at(0.022 + 1e-9), 22.0);
    EXPECT_EQ(e.at(0.03), 22.0);
    EXPECT_EQ(e.pieces.back().end_m, 0.03);
}

}  // namespace
}  // namespace stylet::haptics
