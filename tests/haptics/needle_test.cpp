#include "haptics/tools/needle.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/haptics/puncture.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using test::Hand;
using test::kTorso;
using test::Layers;
using test::makeColumn;
using test::Puncture;

constexpr double kTravel_m = 0.00009;  // per tick

TEST(Needle, SkinIsPuncturedBehindItsSurface) {
    Puncture p(kTorso);
    p.hand.sweep(0.000875 - 1e-6);
    EXPECT_EQ(p.hand.state.phase, Phase::tenting);
    EXPECT_EQ(p.hand.state.tissue, air);
    EXPECT_NEAR(p.hand.force(), 0.7, 0.002);
    p.hand.sweep(0.000875 + 1e-6);
    EXPECT_EQ(p.hand.state.tissue, skin);
    p.expectCut(skin, 0.000875, 0.7, 0.7);
    EXPECT_EQ(p.only(NeedleEventKind::border, skin).force_before_n, 0.0);
}

// HZ-TEACH-02
TEST(Needle, ClosedFormsOfTable1) {
    for (const double step : {0.000013, kTravel_m, 0.0007}) {
        Puncture p({{skin, 0.002},
                    {soft, 0.02},
                    {fascia, 0.003},
                    {liver, 0.03},
                    {duct, 0.004},
                    {liver, 0.02},
                    {vessel, 0.004},
                    {liver, 0.01}});
        p.hand.sweep(0.090, step);
        p.expectCut(skin, 0.000875, 0.7, 0.7);
        p.expectCut(fascia, 0.0018, 2.5, 1.0);
        p.expectCut(duct, 0.0003, 1.2, 0.5);
        p.expectCut(vessel, 0.15 / 1100.0, 1.05, 0.75);
        EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::puncture).size(), 4u);
        const NeedleEvent fat = p.only(NeedleEventKind::entry, soft);
        EXPECT_NEAR(fat.border.depth_m, 0.002, 1e-12);
        EXPECT_NEAR(fat.force_after_n, 0.7, 1e-9);
        EXPECT_NEAR(p.hand.force(), 0.9, 1e-9);
    }
}

TEST(Needle, ForceBehindAFasciaThickOrThin) {
    Puncture thick({{skin, 0.002}, {soft, 0.02}, {fascia, 0.002}, {liver, 0.03}});
    thick.hand.sweep(0.022 + 0.0018 + 1e-6);
    EXPECT_EQ(thick.hand.state.tissue, fascia);
    EXPECT_NEAR(thick.hand.force(), 1.0, 1e-9);

    Puncture thin({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.03}});
    thin.hand.sweep(0.022 + 0.0018 + 1e-6);
    EXPECT_EQ(thin.hand.state.tissue, liver);
    EXPECT_NEAR(thin.hand.force(), 0.9, 1e-9);
}

TEST(Needle, FasciaLiverDuctInOneTick) {
    Puncture p({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.0005}, {duct, 0.005}, {liver, 0.02}});
    p.hand.sweep(0.0237);
    EXPECT_EQ(p.hand.state.phase, Phase::tenting);
    p.hand.events.clear();
    p.hand.to(0.0239);  // past the fascia's puncture at 23.8 mm
    ASSERT_EQ(p.hand.events.size(), 3u);
    EXPECT_EQ(p.hand.events[0].kind, NeedleEventKind::puncture);
    EXPECT_NEAR(p.hand.events[0].force_before_n, 2.5, 1e-9);
    EXPECT_NEAR(p.hand.events[0].force_after_n, 1.0, 1e-9);
    EXPECT_EQ(p.hand.events[1].border.to, liver);
    EXPECT_NEAR(p.hand.events[1].force_after_n, 0.9, 1e-9);
    EXPECT_EQ(p.hand.events[2].kind, NeedleEventKind::border);
    EXPECT_NEAR(p.hand.state.tenting.depth_m, 0.0001, 1e-9);
    EXPECT_NEAR(p.hand.state.tenting.a0_n, 0.9, 1e-9);
    EXPECT_EQ(p.hand.state.tissue, liver);
    p.hand.sweep(0.0238 + 0.0003 - 1e-6);
    EXPECT_EQ(p.hand.state.phase, Phase::tenting);
    p.hand.sweep(0.0238 + 0.0003 + 1e-6);
    EXPECT_EQ(p.hand.state.tissue, duct);
    EXPECT_NEAR(p.hand.force(), 0.5, 1e-9);
}

TEST(Needle, TentingEndsOnWithdrawalAndStartsAgain) {
    Puncture p({{skin, 0.002}, {soft, 0.02}, {fascia, 0.001}, {liver, 0.0005}, {duct, 0.005}, {liver, 0.02}});
    p.hand.sweep(0.02385);
    ASSERT_EQ(p.hand.state.tenting.border.to, duct);
    p.hand.sweep(0.0238);
    EXPECT_NEAR(p.hand.force(), 0.9, 1e-9);
    p.hand.sweep(0.0237);  // back in the liver: the spring relaxes, although the voxel is duct
    EXPECT_NEAR(p.hand.force(), 0.9 - 0.12, 1e-9);
    EXPECT_EQ(p.hand.state.tissue, liver);
    p.hand.sweep(0.0238);
    EXPECT_NEAR(p.hand.force(), 0.9, 1e-9);
    p.hand.sweep(0.0230);
    EXPECT_EQ(p.hand.state.phase, Phase::pass);
    p.hand.sweep(0.0242);
    EXPECT_EQ(p.only(NeedleEventKind::puncture, duct).force_before_n, 1.2);
}

// HZ-FORCE-04
TEST(Needle, ArrivalIsContinuousAndTheTangentBounded) {
    Puncture p(kTorso);
    const double step = 1e-6;
    double last = 0.0;
    for (int i = 0; i < 60000; ++i) {
        p.hand.events.clear();
        p.hand.to(step * i);
        bool jump = false;
        for (const NeedleEvent& e : p.hand.events)
            jump = jump || e.kind != NeedleEventKind::border;
        const double change = std::fabs(p.hand.force() - last);
        last = p.hand.force();
        if (jump) continue;
        ASSERT_LE(change, 2.0 * 1200.0 * step) << "at " << i << " um";
    }
}

TEST(Needle, PunctureDepthDoesNotDependOnA1) {
    for (const double share : {0.0, 0.3, 0.7, 1.0}) {
        Puncture p(kTorso);
        p.hand.settings.a1_share = share;
        p.hand.sweep(0.058, 0.00002);
        p.expectCut(fascia, 0.0018, 2.5, 1.0);
        p.expectCut(duct, 0.0003, 1.2, 0.5);
    }
}

TEST(Needle, ReversalReachesFrictionWithinTwiceTheSpringExtension) {
    Puncture p(kTorso);
    p.hand.sweep(0.040);
    ASSERT_NEAR(p.hand.force(), 0.9, 1e-9);
    const double l_max = 0.9 / 1200.0;
    p.hand.sweep(0.040 - l_max);
    EXPECT_NEAR(p.hand.force(), 0.0, 1e-9);
    p.hand.sweep(0.040 - 2.0 * l_max);
    EXPECT_NEAR(p.hand.force(), -0.9, 1e-9);
    p.hand.sweep(0.035);
    EXPECT_NEAR(p.hand.force(), -0.9, 1e-9);
}

TEST(Needle, WithdrawalHasNoTentingAndEndsTheTrack) {
    Puncture p(kTorso);
    p.hand.sweep(0.058);
    EXPECT_TRUE(p.hand.state.track.past_skin && p.hand.state.track.past_fascia);
    p.hand.events.clear();
    p.hand.sweep(0.0235);
    EXPECT_TRUE(p.hand.state.track.past_fascia);
    EXPECT_NEAR(p.hand.force(), -1.0, 1e-9);
    p.hand.sweep(0.0215);
    EXPECT_FALSE(p.hand.state.track.past_fascia);
    EXPECT_TRUE(p.hand.state.track.past_skin);
    EXPECT_NEAR(p.hand.force(), -0.7, 1e-9);
    p.hand.sweep(0.001);
    EXPECT_FALSE(p.hand.state.track.past_skin);
    EXPECT_EQ(p.hand.state.phase, Phase::pass);
    p.hand.sweep(-0.005);
    ASSERT_EQ(p.hand.events.size(), 1u);
    EXPECT_EQ(p.hand.events[0].kind, NeedleEventKind::withdrawn);
    EXPECT_EQ(p.hand.state.phase, Phase::outside);
    EXPECT_EQ(p.hand.force(), 0.0);
    EXPECT_GT(p.hand.state.cut_count, 0);
}

TEST(Needle, ExistingHoleDoesNotTentAgain) {
    for (const auto& [aside_m, cuts] : {std::pair{0.0, 0u}, std::pair{0.0014, 0u}, std::pair{0.0016, 3u}}) {
        Puncture p(kTorso);
        p.hand.sweep(0.058);
        p.hand.sweep(-0.005);
        p.hand.events.clear();
        p.hand.to({-0.005, 0.0003 + aside_m, 0.0002});
        p.hand.sweep(0.058);
        EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::puncture).size(), cuts) << aside_m;
        EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::border).size(), cuts) << aside_m;
    }
}

TEST(Needle, WithdrawalFromATentingBorderRetracesTheCurve) {
    Puncture p(kTorso);
    std::vector<double> in;
    p.hand.sweep(0.022);
    for (int i = 0; i <= 17; ++i) {
        p.hand.to(0.022 + 0.0001 * i);
        in.push_back(p.hand.force());
    }
    for (int i = 17; i >= 0; --i) {
        p.hand.to(0.022 + 0.0001 * i);
        EXPECT_NEAR(p.hand.force(), in[std::size_t(i)], 1e-9);
    }
    p.hand.to(0.0219);
    EXPECT_NEAR(p.hand.force(), 0.7 - 0.1, 1e-9);  // back in fat
    EXPECT_EQ(p.hand.state.phase, Phase::pass);
    EXPECT_TRUE(p.hand.eventsOf(NeedleEventKind::puncture).size() == 1u);  // the skin's puncture
}

TEST(Needle, TouchingTheSkinStartsNoTrack) {
    Puncture p(kTorso);
    p.hand.sweep(0.0005);
    EXPECT_NEAR(p.hand.force(), 800.0 * 0.0005 * (0.5 + 0.5 * 0.0005 / 0.000875), 1e-9);
    p.hand.sweep(-0.001);
    EXPECT_EQ(p.hand.state.phase, Phase::outside);
    EXPECT_EQ(p.hand.state.cut_count, 0);
    EXPECT_TRUE(p.hand.eventsOf(NeedleEventKind::withdrawn).empty());
    p.hand.sweep(0.0009);
    EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::puncture).size(), 1u);
}

TEST(Needle, LeavingThroughASkinCornerEndsOutside) {
    Puncture p({{skin, 0.0004}, {air, 0.003}, {skin, 0.002}, {soft, 0.02}});
    p.hand.sweep(0.0003);
    EXPECT_GT(p.hand.force(), 0.1);
    p.hand.sweep(0.002);
    EXPECT_EQ(p.hand.state.phase, Phase::outside);
    EXPECT_EQ(p.hand.force(), 0.0);
    p.hand.sweep(0.010);
    p.expectCut(skin, 0.000875, 0.7, 0.7);
    EXPECT_NEAR(p.hand.state.depth_m, 0.010 - 0.0034, 1e-9);
    const NeedleEvent out = p.only(NeedleEventKind::withdrawn, air);
    EXPECT_NEAR(out.border.reference_m.x, 0.0004, 1e-9);
    EXPECT_EQ(out.border.from, skin);
    EXPECT_NEAR(out.force_before_n, 800.0 * 0.0004 * (0.5 + 0.5 * 0.0004 / 0.000875), 1e-9);
    EXPECT_EQ(out.force_after_n, 0.0);
}

// A needle that has passed through a fold of skin slides in it on the way out.
TEST(Needle, SkinFoldMetFromBehindIsOpen) {
    for (const double fold_m : {0.0004, 0.001, 0.004}) {
        const double body_m = fold_m + 0.003;
        Puncture p({{skin, fold_m}, {air, 0.003}, {skin, 0.002}, {soft, 0.02}});
        p.hand.sweep(body_m + 0.010);
        p.hand.sweep(fold_m + 0.001);
        ASSERT_EQ(p.hand.state.phase, Phase::outside);
        p.hand.events.clear();
        const double l_max = 0.7 / 800.0;
        for (const double share : {0.1, 0.5, 1.0}) {
            const double travel_m = share * std::min(fold_m, 2.0 * l_max) - 1e-6;
            p.hand.sweep(fold_m - travel_m);
            EXPECT_EQ(p.hand.state.phase, Phase::pass);
            EXPECT_NEAR(p.hand.force(), -std::min(0.7, 800.0 * travel_m), 1e-9);
        }
        p.hand.sweep(-0.005);
        EXPECT_EQ(p.hand.state.phase, Phase::outside);
        EXPECT_EQ(p.hand.force(), 0.0);
        EXPECT_TRUE(p.hand.eventsOf(NeedleEventKind::border).empty());
        EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::withdrawn).size(), 1u);
    }
}

// Only a needle that has passed through the fold slides in it.
TEST(Needle, SkinFoldTentsForANeedleThatCameFromElsewhere) {
    const Layers fold{{skin, 0.004}, {air, 0.003}, {skin, 0.002}, {soft, 0.02}};
    const patient::Package package = test::makeColumn(fold);
    const patient::Patient patient(package);
    Hand beside(patient);
    beside.to(0.006);
    beside.sweep(0.0039);
    EXPECT_EQ(beside.eventsOf(NeedleEventKind::border).size(), 1u);
    // It opens once per passage.
    Puncture p(fold);
    p.hand.sweep(0.006);
    p.hand.sweep(-0.005);
    p.hand.to({-0.005, 0.0303, 0.0002});
    p.hand.events.clear();
    EXPECT_EQ(p.hand.state.fold_count, 0);
    // A fold 0.5 mm in front of the body does not open the body's skin.
    Puncture near({{skin, 0.004}, {air, 0.0005}, {skin, 0.002}, {soft, 0.02}});
    near.hand.sweep(0.010);
    EXPECT_EQ(near.hand.eventsOf(NeedleEventKind::puncture).size(), 2u);
}

// A needle that is carried away from a fold does not slide in other skin that it meets from behind.
TEST(Needle, SkinFoldIsForgottenWhenTheNeedleIsCarriedElsewhere) {
    const Layers fold{{skin, 0.004}, {air, 0.003}, {skin, 0.002}, {soft, 0.02}};
    const auto bordersBehind = [&](const std::vector<Vec3>& path) {
        Puncture p(fold, 0.001);
        p.hand.to({-0.005, 0.0, 0.0});
        p.hand.sweep(0.006);
        EXPECT_EQ(p.hand.state.fold_count, 1);
        for (const Vec3& tip_m : path)
            p.hand.to(tip_m);
        p.hand.events.clear();
        p.hand.sweep(0.0035);
        return p.hand.eventsOf(NeedleEventKind::border).size();
    };
    EXPECT_EQ(bordersBehind({}), 0u);
    EXPECT_EQ(bordersBehind({{0.0055, 0.002, 0.0}}), 0u) << "the fold follows the shaft a little";
    EXPECT_EQ(bordersBehind({{0.0055, 0.004, 0.0}}), 1u);
    EXPECT_EQ(bordersBehind({{0.0055, 0.0, 0.004}, {0.0055, 0.0, 0.0}}), 1u) << "and back again";
    // Around the fold, to its front, without passing through it.
    const Vec3 around(0.006, 0.1, 0.0), in_front(-0.005, 0.1, 0.0);
    EXPECT_EQ(bordersBehind({around, in_front, around, {0.006, 0.0, 0.0}}), 1u);
}

// A hole in the skin opens neither bone nor an organ that the needle is pushed into backwards.
TEST(Needle, SkinFoldOpensNothingButSkin) {
    for (const Tissue behind : {bone, liver}) {
        Puncture p({{behind, 0.003}, {air, 0.003}, {skin, 0.002}, {air, 0.010}});
        p.hand.to({-0.005, 0.05, 0.0002}), p.hand.to({0.0045, 0.05, 0.0002});  // around, into the gap
        p.hand.to({0.0045, 0.0003, 0.0002});
        p.hand.sweep(0.010);
        ASSERT_EQ(p.hand.state.fold_count, 1);
        p.hand.to({0.010, 0.05, 0.0002}), p.hand.to({0.0045, 0.05, 0.0002}),
            p.hand.to({0.0045, 0.0003, 0.0002});
        // On the way around the needle has left the fold. This one is where it is now.
        p.hand.state.fold_count = 1, p.hand.state.fold_reference_m = p.hand.state.channel_reference_m;
        p.hand.events.clear();
        p.hand.sweep(0.0029);
        EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::border).size(), 1u) << patient::tissueName(behind);
        EXPECT_EQ(p.hand.state.fold_count, 1);
    }
}

TEST(Needle, EveryFoldOfAStackIsOpenFromBehind) {
    Puncture p({{skin, 0.003}, {air, 0.002}, {skin, 0.004}, {air, 0.002}, {skin, 0.002}, {soft, 0.02}});
    p.hand.sweep(0.020);
    EXPECT_EQ(p.hand.state.fold_count, 2);
    p.hand.events.clear();
    for (const double at_m : {0.0055, 0.0005}) {
        p.hand.sweep(at_m);
        EXPECT_NEAR(p.hand.force(), -0.7, 1e-9) << at_m;
    }
    // Forward and back again inside the stack.
    p.hand.sweep(0.0045);
    EXPECT_EQ(p.hand.state.phase, Phase::outside);
    p.hand.sweep(0.0005);
    EXPECT_NEAR(p.hand.force(), -0.7, 1e-9);
    p.hand.sweep(-0.005);
    EXPECT_TRUE(p.hand.eventsOf(NeedleEventKind::border).empty());
    EXPECT_EQ(p.hand.state.fold_count, 0);
}

TEST(Needle, BoneIsNeverCut) {
    Puncture p({{skin, 0.002}, {soft, 0.01}, {bone, 0.002}, {soft, 0.05}});
    p.hand.sweep(0.012 + 0.003);  // past the far side of the bone voxels
    EXPECT_NEAR(p.hand.force(), 0.7 + 6.0, 1e-9);
    EXPECT_EQ(p.only(NeedleEventKind::border, bone).role, patient::Role::risk);
    p.hand.sweep(0.050);
    EXPECT_EQ(p.hand.force(), 22.0);
    p.hand.sweep(0.012);
    EXPECT_NEAR(p.hand.force(), 0.7, 1e-9);
    p.hand.sweep(0.0118);
    EXPECT_NEAR(p.hand.force(), 0.5, 1e-9);
}

// The tip is pushed so hard that it lies behind the voxels of an 8 mm thick rib, then dragged along it. Only
// at the rib's edge may it slip off.
TEST(Needle, DraggingAlongARibDoesNotPassThroughIt) {
    constexpr double kEdge_m = 0.006, kReach_m = 0.5 / 150.0;
    patient::Package package = test::repeatColumn(
        makeColumn({{skin, 0.002}, {soft, 0.010}, {bone, 0.008}, {liver, 0.020}}, 0.0005), 60, 0.0005);
    forEachVoxel(package.labels.grid, [&](const Index3& i) {
        if (package.labels[i] == std::uint8_t(bone) && package.labels.grid.centre(i).z > kEdge_m)
            package.labels[i] = std::uint8_t(soft);
    });
    const patient::Patient patient(package);
    Hand hand(patient);
    hand.to(-0.005);
    hand.sweep(0.0225);
    EXPECT_NEAR(hand.force(), 0.7 + 2000.0 * 0.0105, 1e-9);
    double z_m = 0.0;
    for (; z_m < kEdge_m + kReach_m; z_m += 0.0001) {
        hand.to(Vec3(0.0225, 0.0003, z_m));
        ASSERT_NEAR(hand.force(), 0.7 + 2000.0 * 0.0105, 1e-9) << z_m;
    }
    EXPECT_TRUE(hand.eventsOf(NeedleEventKind::sideways).empty());
    hand.to(Vec3(0.0225, 0.0003, z_m + 0.001));
    ASSERT_EQ(hand.eventsOf(NeedleEventKind::sideways).size(), 1u);
    EXPECT_EQ(hand.state.tissue, liver);
    EXPECT_NEAR(hand.force(), 0.9, 1e-9);
}

// The withdrawal is divided into 1 to 200 steps. Rounding must not leave the tip pressed on the bone.
TEST(Needle, EachContactWithBoneIsReported) {
    for (int division = 1; division <= 200; ++division) {
        Puncture p({{skin, 0.002}, {soft, 0.01}, {bone, 0.01}});
        p.hand.sweep(0.012 + 0.0005);
        p.hand.sweep(0.012 - 0.00005, 0.00055 / division);
        EXPECT_EQ(p.hand.state.phase, Phase::pass) << division;
        p.hand.sweep(0.013);
        const std::vector<NeedleEvent> borders = p.hand.eventsOf(NeedleEventKind::border);
        EXPECT_EQ(std::count_if(borders.begin(), borders.end(),
                                [](const NeedleEvent& e) { return e.border.to == bone; }),
                  2)
            << division;
    }
}

TEST(Needle, WithdrawalFromBoneReturnsToTheTentingFascia) {
    Puncture p({{skin, 0.002}, {soft, 0.01}, {fascia, 0.001}, {bone, 0.01}});
    p.hand.sweep(0.013);
    const double at_bone = p.hand.force();
    EXPECT_NEAR(at_bone, 0.7 + 500.0 * 0.001 + 1000.0 * 500.0 / 1.8 * 1e-6, 1e-9);
    p.hand.sweep(0.015);
    EXPECT_NEAR(p.hand.force(), at_bone + 4.0, 1e-9);
    EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::puncture).size(), 1u);  // the skin's puncture
    p.hand.sweep(0.0125);
    EXPECT_EQ(p.hand.state.tenting.border.to, fascia);
    EXPECT_NEAR(p.hand.force(), 0.7 + 500.0 * 0.0005 + 1000.0 * 500.0 / 1.8 * 0.25e-6, 1e-9);
}

TEST(Needle, AirInsideIsARiskWithoutForce) {
    Puncture p({{skin, 0.002}, {soft, 0.01}, {air, 0.01}, {soft, 0.02}});
    p.hand.sweep(0.015);
    EXPECT_EQ(p.only(NeedleEventKind::entry, air).role, patient::Role::risk);
    EXPECT_EQ(p.hand.force(), 0.0);
    EXPECT_EQ(p.hand.state.phase, Phase::pass);
    p.hand.sweep(0.013);  // withdrawing inside the gas does not leave the skin
    EXPECT_TRUE(p.hand.state.track.past_skin);
    EXPECT_TRUE(p.hand.eventsOf(NeedleEventKind::withdrawn).empty());
    p.hand.sweep(0.0225);  // the far wall tents like fat met with zero force
    EXPECT_EQ(p.hand.state.phase, Phase::tenting);
}

TEST(Needle, OneVoxelMembraneKeepsTenting) {
    Puncture p({{skin, 0.0001}, {soft, 0.02}, {fascia, 0.0001}, {liver, 0.02}});
    p.hand.sweep(0.03);
    p.expectCut(skin, 0.000875, 0.7, 0.7);
    p.expectCut(fascia, 0.0018, 2.5, 1.0);
}

TEST(Needle, ThinNonMembraneTissueIsLeftOnItsFarSide) {
    Puncture p({{skin, 0.002}, {soft, 0.01}, {liver, 0.01}, {duct, 0.0001}, {liver, 0.02}});
    p.hand.sweep(0.0222);
    EXPECT_EQ(p.hand.eventsOf(NeedleEventKind::puncture).size(), 1u);  // the skin's puncture
    const NeedleEvent left = p.only(NeedleEventKind::entry, duct);
    EXPECT_NEAR(left.force_before_n, 0.9 + 500.0 * 0.0001 + 1000.0 * 500.0 / 0.3 * 1e-8, 1e-9);
    EXPECT_NEAR(left.force_after_n, 0.5, 1e-9);
    EXPECT_NEAR(p.hand.force(), 0.5 + 1200.0 * 0.0001, 1e-9);
}

// The corner is 0.2 mm thick, but the puncture needs 0.3 mm. The corner is left without a puncture, so the
// wall 0.8 mm deeper tents again.
TEST(Needle, ClippedCornerDoesNotPunctureTheWallBehindIt) {
    Puncture p({{skin, 0.002}, {liver, 0.02}, {duct, 0.0002}, {liver, 0.0008}, {duct, 0.004}, {liver, 0.01}});
    p.hand.sweep(0.03);
    p.expectCut(duct, 0.0003, 1.2, 0.5);
    EXPECT_NEAR(p.only(NeedleEventKind::puncture, duct).border.depth_m, 0.023, 1e-9);
}

TEST(Needle, ManyBordersBehindOneMembraneAreCounted) {
    test::Layers layers{{skin, 0.002}, {soft, 0.01}, {fascia, 0.0001}};
    for (int i = 0; i < 15; ++i)
        layers.insert(layers.end(), {{liver, 0.00005}, {soft, 0.00005}});
    layers.push_back({soft, 0.02});
    Puncture fits(layers, 0.00005);
    fits.hand.sweep(0.02);
    EXPECT_TRUE(fits.hand.eventsOf(NeedleEventKind::overflow).empty());

    layers.resize(3);
    for (int i = 0; i < 17; ++i)
        layers.insert(layers.end(), {{liver, 0.00005}, {soft, 0.00005}});
    layers.push_back({soft, 0.02});
    Puncture over(layers, 0.00005);
    over.hand.sweep(0.02);
    EXPECT_EQ(over.hand.eventsOf(NeedleEventKind::overflow).size(), 2u);
    EXPECT_NEAR(over.only(NeedleEventKind::puncture, fascia).force_before_n, 2.5, 1e-9);
}

TEST(Needle, LabelChangeWithinATissueDoesNotChangeTheForce) {
    patient::Package whole = makeColumn({{skin, 0.002}, {soft, 0.03}, {liver, 0.02}});
    patient::Package parts = whole;
    patient::Label kidney = test::tissueLabels()[std::size_t(soft) - 1];
    kidney.id = 40, kidney.role = patient::Role::risk;
    parts.label_table.push_back(kidney);
    for (int i = 100; i < 320; ++i)
        parts.labels[{i, 0, 0}] = i < 200 ? std::uint8_t(40) : std::uint8_t(0);
    for (int i = 200; i < 320; ++i)
        parts.ct[{i, 0, 0}] = 40;
    const patient::Patient a(whole), b(parts);
    Hand one(a), other(b);
    one.to(-0.001), other.to(-0.001);
    for (const double x : {0.0095, 0.0092, 0.015, 0.0147, 0.022, 0.019, 0.04}) {  // forces of both signs
        for (Hand* h : {&one, &other})
            h->sweep(x);
        EXPECT_EQ(one.force(), other.force()) << x;
    }
    EXPECT_EQ(other.eventsOf(NeedleEventKind::entry)[1].border.to_label, 40);
    EXPECT_EQ(other.eventsOf(NeedleEventKind::entry)[1].role, patient::Role::risk);
}

TEST(Needle, LateralSpringSaturatesAndCutsTheChannel) {
    Puncture p(kTorso);
    p.hand.sweep(0.040);
    const Vec3 tip = p.hand.state.tip_deformed_m;
    p.hand.to(tip + Vec3(0.0, 0.002, 0.0));
    EXPECT_NEAR(needleForce(p.hand.state, p.hand.settings, p.hand.axis).y, -0.3, 1e-9);
    EXPECT_EQ(p.hand.state.lateral_cut_m, 0.0);
    p.hand.to(tip + Vec3(0.0, 0.005, 0.0));
    EXPECT_NEAR(needleForce(p.hand.state, p.hand.settings, p.hand.axis).y, -0.5, 1e-9);
    EXPECT_NEAR(p.hand.state.lateral_cut_m, 0.005 - 0.5 / 150.0, 1e-9);
    EXPECT_NEAR(p.hand.state.channel_reference_m.y, tip.y + 0.005 - 0.5 / 150.0, 1e-9);
    p.hand.to(tip + Vec3(0.0, 0.003, 0.0));  // back into the channel that was cut
    EXPECT_NEAR(needleForce(p.hand.state, p.hand.settings, p.hand.axis).y, -0.5 + 0.3, 1e-9);
    EXPECT_NEAR(p.hand.force(), 0.9, 1e-9);
}

// The shaft turns about a tip that lies 3 mm beside its channel. The channel gets deeper by 3 mm sin(0.15).
TEST(Needle, RotatingTheShaftCrossesBorders) {
    Puncture p({{skin, 0.002}, {liver, 0.02}, {duct, 0.004}, {liver, 0.02}});
    p.hand.sweep(0.0218);
    const Vec3 beside = p.hand.state.tip_deformed_m + Vec3(0.0, 0.003, 0.0);
    p.hand.to(beside);
    const double depth_m = p.hand.state.depth_m;
    for (int i = 1; i <= 15; ++i) {
        p.hand.axis = Vec3(std::cos(0.01 * i), std::sin(0.01 * i), 0.0);
        p.hand.to(beside);
    }
    EXPECT_NEAR(p.hand.state.depth_m - depth_m, 0.003 * std::sin(0.15), 1e-5);
    EXPECT_EQ(p.hand.state.phase, Phase::tenting);
    EXPECT_EQ(p.hand.state.tenting.border.to, duct);
    EXPECT_GT(p.hand.force(), 1.0);

    for (int i = 14; i >= 0; --i) {
        p.hand.axis = Vec3(std::cos(0.01 * i), std::sin(0.01 * i), 0.0);
        p.hand.to(beside);
    }
    EXPECT_NEAR(p.hand.state.depth_m, depth_m, 1e-5);
}

// A diagonal path through an edge shared by four voxels touches a vessel but does not enter it.
TEST(Needle, ZeroDepthCornerHidesNoBorder) {
    patient::Package package =
        test::repeatColumn(makeColumn({{skin, 0.002}, {liver, 0.02}, {duct, 0.004}}, 0.001), 60, 0.001);
    const Grid& grid = package.labels.grid;
    const Index3 last_of_liver = grid.nearest({0.0215, 0.0005, 0.0005});
    for (int y = 0; y <= last_of_liver.y; ++y)
        for (int z = 0; z < grid.dims.z; ++z)
            package.labels[{last_of_liver.x + 1, y, z}] = std::uint8_t(vessel);
    const patient::Patient patient(package);
    const Vec3 corner = grid.centre(last_of_liver) + 0.5 * grid.spacing_m * Vec3(1.0, 1.0, 0.0);
    Hand hand(patient);
    hand.axis = glm::normalize(Vec3(1.0, 1.0, 0.0));
    for (int i = -400; i <= 40; ++i)
        hand.to(corner + hand.axis * (0.0001 * i));
    int cut_ducts = 0;
    for (const NeedleEvent& e : hand.eventsOf(NeedleEventKind::puncture))
        cut_ducts += e.border.to == duct;
    EXPECT_EQ(cut_ducts, 1);
}

TEST(Needle, BordersCrossedSidewaysAreHitsWithoutTenting) {
    // The layers are stacked along x. The needle enters along y (from the air at y < -40 mm) and is dragged
    // along x.
    const patient::Package package = makeColumn({{liver, 0.02}, {duct, 0.02}});
    const patient::Patient patient(package);
    Hand hand(patient);
    hand.axis = {0.0, 1.0, 0.0};
    hand.to({0.018, -0.045, 0.0});
    for (int i = 0; i < 400; ++i)
        hand.to({0.018, -0.045 + 0.0001 * i, 0.0});
    hand.events.clear();
    for (int i = 0; i < 100; ++i)
        hand.to({0.018 + 0.0001 * i, -0.0051, 0.0});
    ASSERT_EQ(hand.events.size(), 1u);
    EXPECT_EQ(hand.events[0].kind, NeedleEventKind::sideways);
    EXPECT_EQ(hand.events[0].role, patient::Role::target);
    EXPECT_NEAR(hand.events[0].border.reference_m.x, 0.020, 1e-9);
    EXPECT_EQ(hand.state.tissue, duct);
    EXPECT_NEAR(hand.force(), 0.5, 1e-9);
    EXPECT_NEAR(hand.state.lateral_cut_m, 0.0099 - 0.5 / 150.0, 1e-9);
}

}  // namespace
}  // namespace stylet::haptics
