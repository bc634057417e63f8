// Tests each rule of a puncture separately with hand-made ticks: steps, hits and near misses.
#include "app/training/procedure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "app/training/tutor.h"
#include "tests/app/training/procedure_fixture.h"

namespace stylet::training {
namespace {

using haptics::NeedleEvent;
using haptics::NeedleEventKind;

// Two ribs, 10 mm deep and 10 mm to either side of the path. The path runs through the gap between them.
patient::Package wallWithRibs() {
    patient::Package package = test::wallWithVessel();
    LabelVolume& labels = package.labels;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        const Vec3 p = labels.grid.centre(i);
        const double z = std::fabs(p.z);
        if (p.x > 0.010 && p.x < 0.014 && z > 0.007 && z < 0.013) labels[i] = test::kBoneLabel;
    });
    return package;
}

class ProcedureWithRibsTest : public ProcedureTest {
  protected:
    ProcedureWithRibsTest() : ProcedureTest(wallWithRibs()) {}
};

TEST_F(ProcedureWithRibsTest, FingerMustFeelTheGapAndBothRibs) {
    const Vec3 gap{0.002, 0.015, 0.002}, upper{0.002, 0.0, 0.010}, lower{0.002, 0.0, -0.010};
    update(finger({0.002, 0.0, 0.018}, 0.3), 1000);  // beyond the upper rib
    update(finger(upper, 0.3), 1000), update(finger(lower, 0.3), 1000);
    EXPECT_FALSE(done(Step::findGap)) << "the gap is missing";
    update(finger(gap, 0.01), 1000);
    EXPECT_FALSE(done(Step::findGap)) << "hardly touching";
    update(finger(gap, 0.3), 100);
    EXPECT_FALSE(done(Step::findGap)) << "too short to feel";
    update(finger(gap, 0.3), 400);
    EXPECT_TRUE(done(Step::findGap)) << "further along the same space";
    EXPECT_EQ(progress().step, Step::findDuct);
}

TEST_F(ProcedureWithRibsTest, FingerPutDownTooEarlyIsToldWhatIsMissing) {
    const auto putDown = [&] {
        TickOutput needle = needleAt({-0.05, 0, 0}, Tissue::air, 0);
        update(needle, 10);
        return progress().refusal;
    };
    update(finger({0.002, 0.0, 0.010}, 0.3), 300);
    EXPECT_EQ(putDown(), Refusal::gapNotFelt);
    update(finger({0.002, 0.0, 0.0}, 0.3), 300);
    EXPECT_EQ(putDown(), Refusal::lowerRibNotFelt);
    update(finger({0.002, 0.0, -0.025}, 0.3), 300);
    EXPECT_EQ(putDown(), Refusal::lowerRibNotFelt) << "that was the belly, beyond the rib";
    update(finger({0.002, 0.0, -0.010}, 0.3), 300);
    EXPECT_TRUE(done(Step::findGap));
}

TEST_F(ProcedureWithRibsTest, DuctIsVisibleUnlessARibShadowsIt) {
    TickOutput probe = probeAt({0.0, 0.0, 0.0105}, glm::normalize(Vec3(0.053, 0.0, -0.0105)));
    update(probe, 1500);
    EXPECT_FALSE(done(Step::findDuct)) << "in a rib's shadow";
    update(probeAt({0.0, 0.0, 0.0}, glm::normalize(Vec3(1.0, 0.0, 0.3))), 1500);
    EXPECT_FALSE(done(Step::findDuct)) << "the picture leans off the duct";
    probe = probeAt({0.0, 0.0, 0.0}, {1, 0, 0});
    probe.probe_touching_share = 0.1;
    update(probe, 1500);
    EXPECT_FALSE(done(Step::findDuct)) << "hardly any contact, no picture";
    probe.probe_touching_share = 0.5;
    update(probe, 900);
    EXPECT_FALSE(done(Step::findDuct)) << "a glance";
    probe.probe_touching_share = 0.0;
    update(probe, 100);
    probe.probe_touching_share = 0.5;
    update(probe, 900);
    EXPECT_FALSE(done(Step::findDuct)) << "a second glance";
    update(probe, 200);
    EXPECT_TRUE(done(Step::findDuct));
}

TEST_F(ProcedureWithRibsTest, ParkedProbeThatShowsNothingIsToldWhy) {
    TickOutput probe = probeAt({0.0, 0.0, 0.0105}, glm::normalize(Vec3(0.053, 0.0, -0.0105)));
    update(probe, 100);
    update(parked(probe), 100);
    EXPECT_EQ(progress().refusal, Refusal::ductShadowed);
    probe = probeAt({0.0, 0.0, 0.0}, glm::normalize(Vec3(1.0, 0.0, 0.3)));
    update(probe, 100);
    update(parked(probe), 100);
    EXPECT_TRUE(progress().refusal == Refusal::ductBesidePlane ||
                progress().refusal == Refusal::ductOutsidePicture)
        << int(progress().refusal);
    EXPECT_FALSE(done(Step::findDuct));
    update(parked(probeAt({0.0, 0.0, 0.0}, {1, 0, 0})), 1200);
    EXPECT_TRUE(done(Step::findDuct)) << "a parked probe counts if it shows the duct";
}

TEST_F(ProcedureTest, IncisionIsAtTheEntryAndOfUsefulLength) {
    const auto cut = [&](double z_m, double length_m) {
        TickOutput out;
        out.tool = Tool::scalpel;
        out.incision_count = 1, out.cut_incision = 0;
        out.newest_incision = out.cut = {{0.0, -0.5 * length_m, z_m}, {0.0, 0.5 * length_m, z_m}};
        update(out, 10);
        EXPECT_FALSE(done(Step::incise)) << "the blade is still in the skin";
        out.cut_incision = -1;
        update(out, 10);
        return progress().refusal;
    };
    EXPECT_EQ(cut(0.030, 0.006), Refusal::incisionAside);
    EXPECT_EQ(cut(0.006, 0.006), Refusal::incisionAside);
    EXPECT_EQ(cut(0.002, 0.002), Refusal::incisionTooShort);
    EXPECT_EQ(progress().step, Step::findGap);
    EXPECT_EQ(cut(0.002, 0.040), Refusal::incisionTooLong);
    cut(0.002, 0.006);
    EXPECT_TRUE(done(Step::incise));
}

// A wound cannot be made shorter: the tutor must not ask for it for ever.
TEST_F(ProcedureTest, TooLongAnIncisionIsLeftBehind) {
    update(finger({0.002, 0.0, 0.0}, 0.3), 300);
    update(probeAt({0.0, 0.0, 0.0}, {1, 0, 0}), 1200);
    ASSERT_EQ(progress().step, Step::incise);
    TickOutput out;
    out.tool = Tool::scalpel;
    out.incision_count = 1, out.cut_incision = 0;
    out.cut = {{0.0, -0.020, 0.002}, {0.0, 0.020, 0.002}};
    update(out);
    out.cut_incision = -1;
    update(out);
    EXPECT_EQ(progress().refusal, Refusal::incisionTooLong);
    EXPECT_FALSE(done(Step::incise));
    EXPECT_EQ(progress().step, Step::guide);
}

// The entry may also be where the parked probe's rail meets the skin.
TEST_F(ProcedureTest, IncisionOnTheRailIsAtTheEntry) {
    TickOutput out = parked(probeAt({0.0, 0.0, 0.050}, {1, 0, 0}));
    const Pose rail = out.patient_from_probe * haptics::GuideSettings{}.probe_from_guide;
    const Vec3 along = rail.direction({0, 0, 1});
    const Vec3 on_skin = rail.position_m - along * (rail.position_m.x / along.x);
    out.tool = Tool::scalpel;
    out.incision_count = 1, out.cut_incision = 0;
    out.newest_incision = out.cut = {on_skin + Vec3(0.0, -0.003, 0.0), on_skin + Vec3(0.0, 0.003, 0.0)};
    update(out, 10);
    out.cut_incision = -1;
    update(out, 10);
    EXPECT_TRUE(done(Step::incise)) << glm::length(on_skin - package_.ct.grid.origin_m);
}

TEST_F(ProcedureTest, GuideCountsOnlyInTheBodyOnTheRailOfAParkedProbe) {
    TickOutput out = needleAt({-0.010, 0, 0}, Tissue::air, 0);
    out.needle_in_guide = out.probe_parked = true;
    update(out, 1000);
    EXPECT_FALSE(done(Step::guide)) << "in the air";
    update(needleAt({0.001, 0, 0}, Tissue::skin, 1), 10);
    EXPECT_EQ(progress().refusal, Refusal::none) << "a mere touch";
    update(needleAt({0.003, 0, 0}, Tissue::soft, 2), 10);
    EXPECT_EQ(progress().refusal, Refusal::needleNotInGuide);
    out = needleAt({0.003, 0, 0}, Tissue::soft, 2);
    out.needle_in_guide = out.probe_parked = true;
    update(out, 10);
    EXPECT_FALSE(done(Step::guide)) << "it went in beside the rail";
    update(needleAt({-0.010, 0, 0}, Tissue::air, 0));
    update(out, 10);
    EXPECT_TRUE(done(Step::guide));
}

TEST_F(ProcedureTest, StepsOutOfOrderAreAllowedAndCounted) {
    TickOutput out = needleAt({0.003, 0, 0}, Tissue::soft, 2);
    out.needle_in_guide = out.probe_parked = true;
    update(needleAt({-0.010, 0, 0}, Tissue::air, 0));
    update(out, 10);
    EXPECT_TRUE(done(Step::guide));
    EXPECT_EQ(progress().out_of_order, 0u) << "a step that never comes is not out of order";
    EXPECT_EQ(progress().step, Step::findGap);
    update(finger({0.002, 0.0, 0.0}, 0.3), 400);
    EXPECT_EQ(progress().out_of_order, 1u) << "the guide came before the finger";
    EXPECT_EQ(value(MetricId::procedure), 25.0);
    std::vector<SessionEvent> steps = procedure_.consumeEvents();
    std::erase_if(steps, [](const SessionEvent& e) { return e.kind != "step"; });
    ASSERT_EQ(steps.size(), 2u);
    EXPECT_NE(steps[1].text.find("after a later one"), std::string::npos);
}

// The tutor asks to aim whenever the guide's line does not meet the duct.
class AimTest : public ProcedureTest {
  protected:
    AimTest() {
        update(finger({0.002, 0.0, 0.0}, 0.3), 400);
        update(probe(kOnDuct), 1100);
        EXPECT_EQ(progress().step, Step::incise);
        EXPECT_EQ(next(probe(kOnDuct)), Act::parkProbe);
        EXPECT_EQ(next(parked(probe(kOnDuct))), Act::selectScalpel);
    }
    // A line along which the guide leads the needle.
    struct Line {
        Vec3 from_m, along;
    };
    static TickOutput probe(const Line& line, double touching_share = 1.0, bool breath_held = true) {
        TickOutput out;
        out.tool = Tool::probe;
        out.tool_awaits_exit = false;
        out.probe_touching_share = touching_share, out.breath_held = breath_held;
        out.patient_from_tool = trainer::toolPoseFromNeedle(trainer::needlePose(line.from_m, line.along),
                                                            Tool::probe, haptics::GuideSettings{});
        return out;
    }
    Act next(const TickOutput& out) {
        update(out, 40);
        return nextAct(progress(), out, {});
    }
    static constexpr double kHalf = 0.70710678;
    static inline const Line kOnDuct{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}},
        kAside{{0.0, 0.03, 0.0}, {0.6, 0.8, 0.0}},
        // Of the part of it that is near the target, between 0.5 and 1.5 mm lie in the duct.
        kGrazing{{0.0, -0.0335, 0.0}, {kHalf, kHalf, 0.0}};
};

TEST_F(AimTest, AProbeThatWasLiftedIsAimedAnew) {
    EXPECT_EQ(next(probe(kOnDuct, 0.0)), Act::placeProbe);
    EXPECT_EQ(next(probe(kAside, 1.0, false)), Act::holdBreath);
    EXPECT_EQ(next(parked(probe(kAside, 1.0, false))), Act::liftProbe) << "parked before it was aimed";
    EXPECT_EQ(next(probe(kAside)), Act::aimGuide);
    EXPECT_EQ(next(parked(probe(kAside))), Act::liftProbe);
    TickOutput with_scalpel = parked(probe(kAside));
    with_scalpel.tool = Tool::scalpel;
    EXPECT_EQ(next(with_scalpel), Act::liftProbe);
    EXPECT_EQ(next(parked(probe(kOnDuct))), Act::selectScalpel);
}

// The breath-hold drifts under a parked probe: a line that grazes the duct may be tried, until it has failed.
TEST_F(AimTest, ALineThatOnlyGrazesTheDuctIsAimedAnewAfterAMiss) {
    const TickOutput grazing = parked(probe(kGrazing));
    EXPECT_EQ(next(grazing), Act::selectScalpel);
    const auto needle = [&](TickOutput out) {
        out.breath_held = out.probe_parked = true;
        out.patient_from_probe = grazing.patient_from_probe;
        out.tool_awaits_exit = false;
        return out;
    };
    update(needle(liver(0.030)));
    EXPECT_EQ(next(needle(liver(0.065))), Act::withdrawToRetry);
    EXPECT_EQ(progress().refusal, Refusal::ductMissed);
    EXPECT_EQ(next(needle(needleAt({-0.010, 0.0, 0.0}, Tissue::air, 0))), Act::liftProbe);
}

// The puncture counts in a breath-hold, with needle and duct in the picture.
// HZ-TEACH-17
TEST_F(ProcedureTest, PunctureNeedsHoldAndPicture) {
    const TickOutput in_plane = parked(probeAt({0.0, 0.0, 0.0}, {1, 0, 0}));
    const auto puncture = [&](bool held, const std::optional<TickOutput>& probe) {
        update(needleAt({-0.010, 0, 0}, Tissue::air, 0));
        const auto at = [&](double x_m, Tissue tissue, std::uint8_t label) {
            TickOutput out = needleAt({x_m, 0.0, 0.0}, tissue, label);
            out.breath_held = held;
            if (probe) out.probe_parked = true, out.patient_from_probe = probe->patient_from_probe;
            return out;
        };
        for (double x_m = 0.002; x_m < 0.049; x_m += 0.002)
            update(at(x_m, Tissue::liver, test::kLiverLabel));
        const TickOutput inside = at(0.0505, Tissue::duct, test::kDuctLabel);
        update(inside);
        NeedleEvent cut;
        cut.kind = NeedleEventKind::puncture;
        cut.border.to = Tissue::duct;
        cut.force_before_n = 1.25;
        procedure_.update(cut, inside, true);
        update(inside, 5);
        EXPECT_TRUE(progress().success);
        return progress().refusal;
    };
    EXPECT_EQ(puncture(true, std::nullopt), Refusal::needleNotSeen);
    EXPECT_EQ(value(MetricId::procedure), 12.5) << "the duct was cut blindly";
    EXPECT_EQ(value(MetricId::peakForce), 1.25);
    const TickOutput beside = parked(probeAt({0.0, 0.0, 0.008}, {1, 0, 0}));
    EXPECT_EQ(puncture(true, beside), Refusal::needleNotSeen);
    EXPECT_EQ(puncture(false, in_plane), Refusal::breathNotHeld);
    TickOutput later = needleAt({0.0505, 0.0, 0.0}, Tissue::duct, test::kDuctLabel);
    later.breath_held = later.probe_parked = true;
    later.patient_from_probe = in_plane.patient_from_probe;
    update(later, 100);
    EXPECT_FALSE(done(Step::advance)) << "the breath held afterwards";
    puncture(true, in_plane);
    EXPECT_TRUE(done(Step::advance));
    update(needleAt({0.0515, 0.0, 0.0}, Tissue::duct, test::kDuctLabel));
    EXPECT_GT(progress().total, 0.0);
}

TEST_F(ProcedureTest, DistancesAreMeasuredFromThePath) {
    TickOutput out = liver(0.030, 0.004);
    const double lean = 0.1;
    out.patient_from_needle = trainer::needlePose({0.030, 0.004, 0.0}, {std::cos(lean), std::sin(lean), 0.0});
    update(out);
    EXPECT_NEAR(progress().off_path_m, 0.004, 1e-9);
    EXPECT_NEAR(progress().off_angle_rad, lean, 1e-9);
    EXPECT_NEAR(progress().to_target_m, std::hypot(0.023, 0.004), 1e-9);
}

// A probe that is held well shows no distance and no angle, although its face is beside the path.
TEST_F(ProcedureTest, DistancesOfTheProbeAreThoseOfItsGuide) {
    const Pose needle = trainer::needlePose({0.0, 0.002, 0.0}, {1, 0, 0});
    TickOutput out;
    out.tool = Tool::probe;
    out.patient_from_tool = trainer::toolPoseFromNeedle(needle, Tool::probe, {});
    update(out);
    EXPECT_NEAR(progress().off_path_m, 0.002, 1e-9);
    EXPECT_NEAR(progress().off_angle_rad, 0.0, 1e-6);
    out.patient_from_tool = trainer::needlePose({0.0, 0.0, 0.0}, {1, 0, 0});
    update(out);
    EXPECT_NEAR(progress().off_angle_rad, 25.0 * 0.017453292519943295, 1e-6) << "the face lies on the path";
}

// HZ-TEACH-17
TEST_F(ProcedureTest, RepeatedVesselContactCountsOnceWithinDebounce) {
    update(liver(0.028));
    update(vessel(), 100);
    EXPECT_EQ(progress().current_risk, RiskStructure::vessel);
    EXPECT_EQ(progress().clearance_m, 0.0);
    update(liver(0.0315), 100);
    update(vessel(), 100);
    EXPECT_EQ(progress().risk_hits, 1u) << "the same visit";
    update(liver(0.0315), 300);
    EXPECT_EQ(progress().current_risk, RiskStructure::nothing);
    update(vessel(), 100);
    EXPECT_EQ(progress().risk_hits, 2u);
    EXPECT_EQ(value(MetricId::vesselHits), 2.0);
    EXPECT_NEAR(value(MetricId::noGoTime), 0.3, 1e-9);
}

TEST_F(ProcedureTest, BoneHitLastsWhileTheNeedleIsBlocked) {
    TickOutput held = liver(0.010);
    held.phase = haptics::Phase::tenting;
    update(held);
    NeedleEvent met;
    met.kind = NeedleEventKind::border;
    met.border.to = Tissue::bone;
    procedure_.update(met, held, false);
    update(held, 50);
    EXPECT_EQ(progress().current_risk, RiskStructure::bone);
    update(liver(0.009));
    EXPECT_EQ(progress().current_risk, RiskStructure::nothing);
    EXPECT_EQ(value(MetricId::boneHits), 1.0);
}

class CartilageTest : public ProcedureTest {
  protected:
    CartilageTest() : ProcedureTest(wallWithCartilage()) {}

  private:
    static patient::Package wallWithCartilage() {
        patient::Package package = test::wallWithVessel();
        for (patient::Label& label : package.label_table)
            if (label.id == test::kVesselLabel)
                label.tissue = Tissue::cartilage, label.blood = patient::BloodKind::none;
        return package;
    }
};

// Cartilage does not stop the needle, but it is as forbidden as bone.
TEST_F(CartilageTest, PassingItCountsAsBoneHit) {
    update(liver(0.028));
    update(needleAt({0.033, 0, 0}, Tissue::cartilage, test::kVesselLabel), 100);
    EXPECT_EQ(progress().current_risk, RiskStructure::bone);
    update(liver(0.0375), 100);
    EXPECT_EQ(progress().current_risk, RiskStructure::nothing);
    EXPECT_EQ(progress().risk_hits, 1u);
    EXPECT_EQ(value(MetricId::boneHits), 1.0);
}

TEST_F(ProcedureTest, NearMissIsGradedAfterItEnds) {
    update(liver(0.025));
    update(liver(0.0305), 50);  // 1.5 mm in front of the vessel
    EXPECT_EQ(progress().near_misses, 0u) << "it may yet be struck";
    EXPECT_NEAR(value(MetricId::nearMisses), 0.25, 1e-3) << "but counts already";
    update(liver(0.0295), 50);  // 2.5 mm: not over yet
    update(liver(0.0310), 50);  // 1 mm
    update(liver(0.0280), 50);  // 4 mm
    EXPECT_EQ(progress().near_misses, 1u);
    EXPECT_NEAR(value(MetricId::nearMisses), 0.5, 1e-3);
    EXPECT_NEAR(value(MetricId::clearance), 1.0, 1e-3);
    update(liver(0.0310), 50);
    update(vessel(), 10);
    update(liver(0.0280), 50);
    EXPECT_EQ(progress().near_misses, 1u) << "that was a hit";
    EXPECT_NEAR(value(MetricId::nearMisses), 1.5, 1e-3) << "which costs no less than the nearest miss";
}

TEST_F(ProcedureTest, VesselBesideTheDuctCountsOnlyWhenStruck) {
    update(liver(0.0410), 50);  // 5 mm past the vessel, 9 mm in front of the duct
    EXPECT_TRUE(std::isnan(value(MetricId::clearance)));
    EXPECT_EQ(value(MetricId::nearMisses), 0.0);
    EXPECT_NEAR(progress().clearance_m, 0.005, 1e-6) << "shown all the same";
}

TEST_F(ProcedureTest, TremorDoesNotCountAsNeedleTravel) {
    for (int n = 0; n < 3000; ++n)
        update(liver(0.025 + 1e-4 * std::sin(0.06 * n)));
    EXPECT_EQ(value(MetricId::needlePath), 0.0);
    for (int n = 0; n <= 1000; ++n)
        update(liver(0.025 - 0.010 * n / 1000.0));
    EXPECT_NEAR(value(MetricId::needlePath), 10.0 / 53.0, 1.1 / 53.0);
    EXPECT_NEAR(value(MetricId::movedBreathing), 10.0, 1.1);
    TickOutput held = liver(0.0);
    held.breath_held = true;
    for (int n = 0; n <= 1000; ++n) {
        held.tip_reference_m = {0.015 + 0.010 * n / 1000.0, 0.0, 0.0};
        held.phase = haptics::Phase::pass;
        update(held);
    }
    EXPECT_NEAR(value(MetricId::movedBreathing), 10.0, 1.1);
    EXPECT_NEAR(value(MetricId::needlePath), 20.0 / 53.0, 2.1 / 53.0);
}

TEST_F(ProcedureTest, RepeatedTouchWithinDebounceCountsOnce) {
    const TickOutput off = finger({-0.01, 0, 0}, 0.0), on = finger({0.001, 0, 0}, 0.2);
    update(on, 10), update(off, 100), update(on, 10);
    EXPECT_EQ(value(MetricId::skinContacts), 1.0);
    update(off, 300), update(on, 10);
    EXPECT_EQ(value(MetricId::skinContacts), 2.0);
    update(needleAt({0.001, 0, 0}, Tissue::skin, 1), 10);
    EXPECT_EQ(value(MetricId::skinContacts), 3.0);
}

TEST_F(ProcedureTest, IdleTraineeHasNoScore) {
    update(needleAt({-0.05, 0, 0}, Tissue::air, 0), 2000);
    EXPECT_EQ(progress().total, 0.0);
    EXPECT_TRUE(std::isnan(value(MetricId::targeting)));
    EXPECT_TRUE(std::isinf(progress().clearance_m));
    EXPECT_NEAR(progress().elapsed_s, 1.999, 1e-9);
}

// The steps of another course neither count nor are missed.
TEST_F(ProcedureTest, PunctureHasNoStepsOfTheDrainage) {
    TickOutput out = liver(0.040);
    out.access.open = out.access.wire_in = true, out.access.in_duct_m = 0.050;
    out.access.drain = haptics::DrainState::in_place;
    update(out, 10);
    EXPECT_EQ(progress().steps_done & ~stepsOf(Course::puncture), 0u);
    EXPECT_EQ(progress().worst_pain, 0.0) << "pain belongs to the drainage";
    EXPECT_EQ(stepsOf(Course::puncture) | stepsOf(Course::drainage), kAllSteps);
}

}  // namespace
}  // namespace stylet::training
