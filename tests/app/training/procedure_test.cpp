// Steps, hits and near misses from hand-made ticks. Tests each rule separately, without a simulation.
#include "app/training/procedure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/hand.h"
#include "tests/app/training/wall.h"
#include "tests/support/constants.h"

namespace stylet::training {
namespace {

using haptics::NeedleEvent;
using haptics::NeedleEventKind;
using haptics::TickOutput;
using haptics::Tool;
using patient::Tissue;
using test::kDt_s;

class ProcedureTest : public testing::Test {
  protected:
    explicit ProcedureTest(patient::Package package = test::wallWithVessel())
        : package_(std::move(package)) {}

    void update(TickOutput out, int times = 1) {
        for (int n = 0; n < times; ++n) {
            out.tick = tick_++;
            procedure_.update(out, fold_);
        }
    }
    TickOutput needleAt(const Vec3& tip_m, Tissue tissue, std::uint8_t label) const {
        TickOutput out;
        out.patient_from_tool = out.patient_from_needle = trainer::needlePose(tip_m, {1, 0, 0});
        out.tip_reference_m = tip_m;
        out.phase = tip_m.x > 0.0 ? haptics::Phase::pass : haptics::Phase::outside;
        out.depth_m = tip_m.x, out.tissue = tissue, out.label = label;
        return out;
    }
    TickOutput vessel() const { return needleAt({0.033, 0, 0}, Tissue::vessel, test::kVesselLabel); }
    TickOutput liver(double x_m, double y_m = 0.0) const {
        return needleAt({x_m, y_m, 0.0}, Tissue::liver, test::kLiverLabel);
    }
    static TickOutput finger(const Vec3& at_m, double force_n) {
        TickOutput out;
        out.tool = Tool::finger;
        out.patient_from_tool = trainer::needlePose(at_m, {1, 0, 0});
        out.tool_force.force_n = {-force_n, 0.0, 0.0};
        return out;
    }
    bool done(Step step) const { return (procedure_.progress().steps_done & 1u << unsigned(step)) != 0; }
    double value(MetricId id) const { return procedure_.score().values[std::size_t(id)]; }
    const Progress& progress() const { return procedure_.progress(); }

    patient::Package package_;
    patient::Patient patient_{package_};
    AttemptFold fold_{patient_, kDt_s};
    Procedure procedure_{patient_, test::wallPath(), kDt_s};
    std::uint64_t tick_ = 1;
};

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

TEST_F(ProcedureWithRibsTest, FingerFindsOnlyThePathsGap) {
    update(finger({0.002, 0.0, 0.010}, 0.3), 1000);
    EXPECT_FALSE(done(Step::findGap)) << "over a rib";
    update(finger({0.002, 0.0, 0.018}, 0.3), 1000);
    EXPECT_FALSE(done(Step::findGap)) << "beyond a rib";
    update(finger({0.002, 0.0, 0.0}, 0.01), 1000);
    EXPECT_FALSE(done(Step::findGap)) << "hardly touching";
    update(finger({0.002, 0.0, 0.0}, 0.3), 100);
    EXPECT_FALSE(done(Step::findGap)) << "too short to feel";
    update(finger({0.002, 0.015, 0.002}, 0.3), 400);
    EXPECT_TRUE(done(Step::findGap)) << "further along the same space";
    EXPECT_EQ(progress().step, Step::findDuct);
}

TEST_F(ProcedureWithRibsTest, DuctIsVisibleUnlessARibShadowsIt) {
    TickOutput probe;
    probe.tool = Tool::probe;
    probe.probe_touching_share = 1.0;
    const auto stand = [&](const Vec3& face_m, const Vec3& into) {
        probe.patient_from_tool = trainer::needlePose(face_m, into);
    };
    stand({0.0, 0.0, 0.0105}, glm::normalize(Vec3(0.053, 0.0, -0.0105)));  // over a rib, toward the target
    update(probe, 1000);
    EXPECT_FALSE(done(Step::findDuct)) << "in a rib's shadow";
    stand({0.0, 0.0, 0.0}, glm::normalize(Vec3(1.0, 0.0, 0.3)));
    update(probe, 1000);
    EXPECT_FALSE(done(Step::findDuct)) << "the picture leans off the duct";
    stand({0.0, 0.0, 0.0}, {1, 0, 0});
    probe.probe_touching_share = 0.0;
    update(probe, 1000);
    EXPECT_FALSE(done(Step::findDuct)) << "no contact, no picture";
    probe.probe_touching_share = 0.5;
    update(probe, 400);
    EXPECT_TRUE(done(Step::findDuct));
    EXPECT_NEAR(value(MetricId::probeTime), 2.4, 1e-9);
}

TEST_F(ProcedureTest, StepsOutOfOrderAreAllowedAndCounted) {
    TickOutput out;
    out.tool = Tool::scalpel;
    out.incision_count = 1;
    out.newest_incision = {{0.0, -0.003, 0.030}, {0.0, 0.003, 0.030}};
    update(out, 10);
    EXPECT_FALSE(done(Step::incise)) << "far from the entry";
    out.newest_incision = {{0.0, -0.003, 0.002}, {0.0, 0.003, 0.002}};
    update(out, 10);
    EXPECT_TRUE(done(Step::incise));
    EXPECT_EQ(progress().out_of_order, 0u) << "a step that never comes is not out of order";
    out.needle_in_guide = true;
    update(out, 10);
    EXPECT_EQ(progress().step, Step::findGap);
    update(finger({0.002, 0.0, 0.0}, 0.3), 400);
    EXPECT_EQ(progress().out_of_order, 2u) << "incision and guide came before the finger";
    EXPECT_EQ(value(MetricId::procedure), 30.0);
    std::vector<SessionEvent> steps = procedure_.consumeEvents();
    std::erase_if(steps, [](const SessionEvent& e) { return e.kind != "step"; });
    ASSERT_EQ(steps.size(), 3u);
    EXPECT_EQ(steps[0].tick, 11u);
    EXPECT_NE(steps[2].text.find("after a later one"), std::string::npos);
}

// HZ-TEACH-17
TEST_F(ProcedureTest, TargetPunctureIsSuccess) {
    update(liver(0.030));
    update(needleAt({0.0505, 0.0, 0.0}, Tissue::duct, test::kDuctLabel));
    NeedleEvent cut;
    cut.kind = NeedleEventKind::puncture;
    cut.border.to = Tissue::duct;
    cut.force_before_n = 1.25;
    procedure_.update(cut, needleAt({0.0505, 0.0, 0.0}, Tissue::duct, test::kDuctLabel), true);
    EXPECT_TRUE(progress().success);
    EXPECT_TRUE(done(Step::advance));
    EXPECT_EQ(value(MetricId::peakForce), 1.25);
    update(needleAt({0.0515, 0.0, 0.0}, Tissue::duct, test::kDuctLabel));
    EXPECT_NEAR(value(MetricId::targeting), 1.5, 1e-9) << "mm beside the target";
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

}  // namespace
}  // namespace stylet::training
