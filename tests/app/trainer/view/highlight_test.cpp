// Where the prompts point. On flat skin at x = 0, with a path along +x, all places are known.
#include "app/trainer/view/highlight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "app/trainer/attempt/tool_pose.h"
#include "app/training/evidence.h"
#include "tests/app/training/wall.h"

namespace stylet::trainer {
namespace {

using haptics::Tool;
using render::Highlight;
using training::Act;

const Vec3 kIn{1.0, 0.0, 0.0};
constexpr double kNear_m = 0.0035;  // rings lie a little above the skin, places are searched in 1 mm steps

class HighlightTest : public testing::Test {
  protected:
    // The needle 30 mm before the entry, the probe parked with its guide on the path.
    HighlightTest() {
        seen_.tick.tool = Tool::needle;
        seen_.tick.patient_from_tool = seen_.tick.patient_from_needle = needlePose(-0.030 * kIn, kIn);
        seen_.tick.probe_parked = true;
        seen_.tick.patient_from_probe = probeAt(Vec3(0.0));
    }
    Pose probeAt(const Vec3& entry_m) const {
        return toolPoseFromNeedle(needlePose(entry_m, kIn), Tool::probe, guide_) * haptics::kStylusFromProbe;
    }
    void holdProbe(const Vec3& entry_m) {
        seen_.tick.tool = Tool::probe;
        seen_.tick.probe_parked = false;
        seen_.tick.patient_from_tool = probeAt(entry_m) * haptics::kStylusFromProbe.inverse();
    }
    // Wire, dilator and drain lie on the path's line.
    void openAccess() {
        haptics::AccessOutput& access = seen_.tick.access;
        access.open = access.wire_in = true;
        access.entry_m = Vec3(0.0), access.base_m = path_.target_m;
    }
    std::vector<Highlight> marks(Act act) const { return places_.highlights(act, seen_); }
    // Expects a ring at this place of the patient.
    void expectRing(Act act, const Vec3& at_m) const {
        for (const Highlight& mark : marks(act))
            if (mark.ring_m > 0.0 && !mark.in_room && glm::distance(mark.at_m, at_m) < kNear_m) return;
        ADD_FAILURE() << "act " << int(act) << ": no ring there";
    }
    // Expects an arrow in this direction, and returns its tip.
    Vec3 expectArrow(Act act, const Vec3& along) const {
        for (const Highlight& mark : marks(act))
            if (mark.arrow_m > 0.0 && !mark.in_room && glm::dot(mark.along, along) > 0.99) return mark.at_m;
        ADD_FAILURE() << "act " << int(act) << ": no arrow in this direction";
        return Vec3(0.0);
    }
    void expectInRoom(Act act, const Vec3& thing) const {
        ASSERT_EQ(marks(act).size(), 1u) << int(act);
        const Highlight mark = marks(act).front();
        EXPECT_TRUE(mark.in_room) << int(act);
        EXPECT_NEAR(mark.at_m.x, thing.x, 0.3);
        EXPECT_NEAR(mark.at_m.z, thing.z, 0.3);
        EXPECT_GT(mark.at_m.y, thing.y) << "points at it from above";
        EXPECT_EQ(mark.along, Vec3(0.0, -1.0, 0.0));
    }

    const patient::Package package_ = test::wallWithVessel();
    const patient::Patient patient_{package_};
    const patient::PlannedPath path_ = test::wallPath();
    const haptics::GuideSettings guide_{};
    const PromptPlaces places_{patient_, path_, guide_};
    FrameState seen_{};
};

TEST_F(HighlightTest, AnInstrumentToTakeIsOnTheInstrumentTable) {
    for (const Act act :
         {Act::selectFinger, Act::selectProbe, Act::selectScalpel, Act::selectGuide, Act::selectSyringe,
          Act::selectWire, Act::selectNeedle, Act::selectDilator, Act::selectDrain})
        expectInRoom(act, render::kTrolley);
}

TEST_F(HighlightTest, AnInstrumentInThePatientIsTakenThere) {
    openAccess();
    expectRing(Act::selectWire, {-0.120, 0.0, 0.0});
    seen_.tick.access.needle_in = true;
    seen_.tick.patient_from_needle = needlePose(path_.target_m, kIn);
    const Vec3 hub_m = path_.target_m - seen_.needle.length_m * kIn;
    for (const Act act : {Act::selectWire, Act::selectNeedle, Act::withdrawNeedle})
        expectRing(act, hub_m);
    seen_.tick.access.needle_in = false;
    seen_.tick.access.dilator_m = 0.010;
    seen_.tick.access.drain = haptics::DrainState::over_wire;
    for (const Act act : {Act::selectDilator, Act::selectDrain})
        expectRing(act, {-0.120, 0.0, 0.0});
}

TEST_F(HighlightTest, FingerAndScalpelGoToTheEntry) {
    expectRing(Act::pressGap, path_.entry_m);
    EXPECT_LT(glm::distance(expectArrow(Act::pressGap, kIn), path_.entry_m), 1e-9);
    seen_.tick.probe_parked = false;
    expectRing(Act::cut, path_.entry_m);
    // A parked probe's guide decides where the needle will enter.
    seen_.tick.probe_parked = true;
    seen_.tick.patient_from_probe = probeAt({0.0, 0.0, 0.006});
    expectRing(Act::cut, {0.0, 0.0, 0.006});
    expectRing(Act::enterWheal, {0.0, 0.0, 0.006});
    expectRing(Act::enterSkin, {0.0, 0.0, 0.006});
}

TEST_F(HighlightTest, ProbeGoesWhereItsGuideLiesOnThePath) {
    const Vec3 face_m = probeAt(Vec3(0.0)).position_m, out = probeAt(Vec3(0.0)).direction({0.0, 0.0, -1.0});
    for (const Vec3& held_m : {Vec3(-0.030, 0.0, 0.0), Vec3(-0.010, 0.020, -0.015)}) {
        holdProbe(held_m);
        expectRing(Act::placeProbe, face_m + 0.006 * out);
    }
    // The probe's face is 60 mm wide: a probe in its place does not hide the ring.
    EXPECT_GT(marks(Act::placeProbe).front().ring_m, 0.033);
    // The probe leans: the place stays, and the arrow shows how it should stand.
    seen_.tick.patient_from_tool.rotation =
        glm::angleAxis(0.4, Vec3(0.0, 0.0, 1.0)) * seen_.tick.patient_from_tool.rotation;
    const Vec3 stands = probeAt(Vec3(0.0)).direction({0.0, 0.0, 1.0});
    expectArrow(Act::placeProbe, stands);
}

TEST_F(HighlightTest, ProbeIsShiftedTowardTheDuct) {
    holdProbe(Vec3(0.0));
    const Pose patient_from_probe = probeAt(Vec3(0.0));
    for (const double side : {1.0, -1.0}) {
        // Plane and guide lie beside the duct.
        holdProbe(side * 0.008 * patient_from_probe.direction({0.0, 1.0, 0.0}));
        expectArrow(Act::shiftProbe, -side * patient_from_probe.direction({0.0, 1.0, 0.0}));
        expectArrow(Act::aimGuide, -side * patient_from_probe.direction({0.0, 1.0, 0.0}));
    }
    holdProbe(Vec3(0.0));
    const Vec3 on_skin_m = expectArrow(Act::aimGuide, kIn);
    EXPECT_LT(glm::distance(on_skin_m, path_.entry_m), kNear_m) << "the guide's line";
}

TEST_F(HighlightTest, ProbeThatStaysIsRinged) {
    holdProbe(Vec3(0.0));
    const Pose probe = probeAt(Vec3(0.0));
    const Vec3 out = probe.direction({0.0, 0.0, -1.0});
    for (const Act act : {Act::turnProbe, Act::holdProbeStill, Act::parkProbe})
        expectRing(act, probe.position_m + 0.020 * out);
    expectArrow(Act::liftProbe, out);
}

TEST_F(HighlightTest, NeedleIsLaidIntoTheGuidesUpperEnd) {
    const Vec3 end_m = seen_.tick.patient_from_probe * guide_.probe_from_guide * Vec3(0, 0, guide_.length_m);
    expectRing(Act::snapNeedle, end_m);
    EXPECT_LT(glm::distance(expectArrow(Act::snapNeedle, kIn), end_m), 1e-9);
}

TEST_F(HighlightTest, NeedleInTheBody) {
    seen_.tick.patient_from_needle = needlePose(0.040 * kIn, kIn);
    seen_.tick.depth_m = 0.040;
    for (const Act act : {Act::seekDuct, Act::pushToCapsule})
        expectRing(act, path_.entry_m);
    const Vec3 hub_m = (0.040 - seen_.needle.length_m) * kIn;
    for (const Act act : {Act::aspirate, Act::inject, Act::numbSkin, Act::numbCapsule, Act::pullNeedleBack,
                          Act::withdrawNumbingNeedle, Act::withdrawToRetry})
        expectRing(act, hub_m);
    EXPECT_LT(expectArrow(Act::withdrawToRetry, -kIn).x, hub_m.x) << "beyond the hub";
    seen_.tick.patient_from_tool = seen_.tick.patient_from_needle;
    expectRing(Act::liftOff, 0.040 * kIn);
    expectArrow(Act::liftOff, -kIn);
}

TEST_F(HighlightTest, WireDilatorAndDrainArePushedAndDrawnAlongTheTrack) {
    openAccess();
    for (const Act act : {Act::feedWire, Act::pushDilator, Act::pushDrain})
        EXPECT_LT(expectArrow(act, kIn).x, -0.120) << int(act);
    for (const Act act : {Act::pullWireBack, Act::withdrawDilator, Act::withdrawDrain, Act::withdrawWire})
        EXPECT_LT(expectArrow(act, -kIn).x, -0.120) << int(act);
    expectRing(Act::injectDrain, {-0.120, 0.0, 0.0});
}

TEST_F(HighlightTest, Equipment) {
    for (const Act act : {Act::pressPedal, Act::releasePedal})
        expectInRoom(act, render::kXrayMonitor);
    expectInRoom(Act::holdBreath, render::kPatientMonitor);
    expectInRoom(Act::advance, render::kUltrasound);
}

TEST_F(HighlightTest, NothingToPointAt) {
    EXPECT_TRUE(marks(Act::finish).empty());
    EXPECT_TRUE(marks(Act::stopInjecting).empty());
}

// Whatever the state is: a number, a direction of length 1, something to see.
TEST_F(HighlightTest, EveryMarkCanBeDrawn) {
    openAccess();
    for (int act = 0; act < training::kActCount; ++act)
        for (const bool parked : {false, true}) {
            seen_.tick.probe_parked = parked;
            for (const Highlight& mark : marks(Act(act))) {
                EXPECT_TRUE(std::isfinite(glm::dot(mark.at_m, mark.at_m))) << act;
                EXPECT_NEAR(glm::length(mark.along), 1.0, 1e-9) << act;
                EXPECT_GT(mark.ring_m + mark.arrow_m, 0.0) << act;
            }
        }
}

// Bone from 6 to 10 mm under the skin, at 12 to 20 mm toward the head and at 14 to 19 mm toward the feet.
TEST(HighlightRibs, TheRibIsPressedOverItsMiddle) {
    patient::Package package = test::wallWithVessel();
    LabelVolume& labels = package.labels;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        const Vec3 p = labels.grid.centre(i);
        const bool upper = p.z > 0.012 && p.z < 0.020, lower = p.z < -0.014 && p.z > -0.019;
        if ((upper || lower) && p.x > 0.006 && p.x < 0.010) labels[i] = test::kBoneLabel;
    });
    const patient::Patient patient(package);
    const PromptPlaces places(patient, test::wallPath(), {});
    const auto ringAt = [&](Act act) { return places.highlights(act, {}).front(); };
    EXPECT_NEAR(ringAt(Act::pressUpperRib).at_m.z, 0.016, 0.002);
    EXPECT_NEAR(ringAt(Act::pressLowerRib).at_m.z, -0.0165, 0.002);
    EXPECT_NEAR(ringAt(Act::pressUpperRib).at_m.x, 0.0, kNear_m);
    EXPECT_EQ(ringAt(Act::pressUpperRib).at_m.y, 0.0);

    const patient::Package smooth = test::wallWithVessel();
    const patient::Patient boneless(smooth);
    EXPECT_FALSE(training::skinOverRib(boneless, test::wallPath(), 1.0));
    EXPECT_FALSE(training::skinOverRib(patient, test::wallPath(), 1.0) ==
                 training::skinOverRib(patient, test::wallPath(), -1.0));
}

}  // namespace
}  // namespace stylet::trainer
