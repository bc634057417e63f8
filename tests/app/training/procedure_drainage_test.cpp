// Tests each rule of a drainage separately with hand-made ticks: steps, anaesthesia, pain, exam and tutor.
#include <gtest/gtest.h>

#include <cmath>

#include "app/training/equipment.h"
#include "app/training/pain.h"
#include "app/training/score.h"
#include "app/training/tutor.h"
#include "tests/app/training/procedure_fixture.h"

namespace stylet::training {
namespace {

class DrainageTest : public ProcedureTest {
  protected:
    DrainageTest() { procedure_.setCourse(Course::drainage); }

    static TickOutput withWire(double in_duct_m) {
        TickOutput out;
        out.tool = Tool::wire;
        out.access.open = out.access.wire_in = true;
        out.access.in_duct_m = in_duct_m;
        out.access.base_m = {0.05, 0.0, 0.0};  // the track is 50 mm long
        return out;
    }
    static TickOutput withDilator(double depth_m) {
        TickOutput out = withWire(0.040);
        out.tool = Tool::dilator;
        out.access.dilator_m = depth_m;
        return out;
    }
    // The end of a drain lies along the duct; the begin of its side holes as well, or in the liver.
    static void curl(TickOutput& out, bool in_liver = false) {
        out.access.drain = haptics::DrainState::in_place;
        out.access.path_m[0] = {in_liver ? 0.045 : 0.053, -0.018, 0.0};
        out.access.path_m[1] = {0.053, -0.010, 0.0};
        out.access.path_m[2] = {0.053, in_liver ? -0.002 : 0.014, 0.0};
        out.access.path_count = 3;
        out.access.drain_m = in_liver ? 0.008 + std::hypot(0.008, 0.008) : 0.024 + 0.008;
    }
    static TickOutput letGo(TickOutput out) {
        out.tool = Tool::finger;
        return out;
    }
    // Injects with the needle at a place.
    void numb(TickOutput out, double ml, double rate_m3_per_s = 1e-6) {
        haptics::TickInput input;
        input.add(anaesthetiseCommand(rate_m3_per_s));
        for (int i = 0; i < int(std::lround(ml / (1e3 * rate_m3_per_s))); ++i) {
            out.tick = tick_;
            fold_.step(i == 0 ? input : haptics::TickInput{}, out);
            update(out);
        }
        input = {};
        input.add(anaesthetiseCommand(0.0));
        out.tick = tick_;
        fold_.step(input, out);
        update(out);
    }
    TickOutput wall(double x_m, double y_m = 0.0) const { return needleAt({x_m, y_m, 0.0}, Tissue::soft, 2); }
    TickOutput outside() const { return needleAt({-0.010, 0, 0}, Tissue::air, 0); }
    // Whether an exam is passed after these errors, if nothing else is missing.
    bool passesIfWellDone(std::uint32_t steps_done = kAllSteps) const {
        Progress exam = progress();
        exam.total = 100.0, exam.steps_done = steps_done;
        return passesExam(exam);
    }
    Drawn draw(TickOutput out) {
        haptics::TickInput input;
        input.add(kAspirate);
        out.tick = tick_;
        fold_.step(input, out);
        update(out);
        return fold_.aspiration().drawn;
    }
};

TEST_F(DrainageTest, WireMustLieDownTheDuctWithoutPiercingIt) {
    update(withWire(0.019), 100), update(letGo(withWire(0.019)));
    EXPECT_EQ(progress().refusal, Refusal::wireNotInDuct);
    TickOutput pierced = withWire(0.050);
    pierced.access.pierced = true;
    update(pierced, 100), update(letGo(pierced));
    EXPECT_EQ(progress().refusal, Refusal::wirePierced);
    EXPECT_FALSE(done(Step::wire));
    update(withWire(0.021));
    EXPECT_TRUE(done(Step::wire));
}

TEST_F(DrainageTest, DilatorMustReachTheDuctOverTheWire) {
    update(withDilator(0.045), 100), update(letGo(withDilator(0.045)));
    EXPECT_EQ(progress().refusal, Refusal::notDilated);
    TickOutput without = withDilator(0.060);
    without.access.wire_in = false;
    update(without, 100);
    EXPECT_FALSE(done(Step::dilate));
    update(withDilator(0.051));
    EXPECT_TRUE(done(Step::dilate));
}

TEST_F(DrainageTest, DrainMustCurlInADuct) {
    TickOutput drain = letGo(withWire(0.040));
    drain.access.drain = haptics::DrainState::over_wire;
    update(drain, 100);
    drain.access.drain = haptics::DrainState::misplaced;
    update(drain, 100);
    EXPECT_EQ(progress().refusal, Refusal::drainMisplaced);
    EXPECT_FALSE(done(Step::drain));
    curl(drain);
    update(drain);
    EXPECT_TRUE(done(Step::drain));
}

// Its tip lies in a duct, and its first side hole in the liver. HZ-TEACH-25
TEST_F(DrainageTest, DrainWithAHoleInTheLiverLeaks) {
    TickOutput drain = letGo(withWire(0.040));
    drain.access.drain = haptics::DrainState::over_wire;
    update(drain, 100);
    curl(drain, true);
    update(drain, 100);
    EXPECT_EQ(progress().refusal, Refusal::drainLeaks);
    EXPECT_FALSE(done(Step::drain));
    EXPECT_EQ(progress().step, Step::drain) << "it can be mended";
    EXPECT_FALSE(passesIfWellDone(kAllSteps & ~maskOf(Step::drain)));
}

// HZ-TEACH-25
TEST_F(DrainageTest, TutorHasALeakingDrainMended) {
    TickOutput drain = letGo(withWire(0.040));
    drain.tool_awaits_exit = false;
    drain.access.drain = haptics::DrainState::over_wire;
    update(drain, 100);
    curl(drain, true);
    drain.access.open = drain.access.wire_in = false;
    drain.tool = Tool::wire;
    update(drain, 100);
    const auto act = [&](const TickOutput& now) { return nextAct(progress(), now, {}); };
    EXPECT_EQ(act(drain), Act::rewireDrain) << "the wire was drawn out of the drain";
    TickOutput wired = drain;
    wired.access.open = wired.access.wire_in = true;
    update(wired);
    EXPECT_EQ(act(wired), Act::straightenDrain);
    EXPECT_EQ(act(letGo(wired)), Act::selectWire);
    wired.access.drain = haptics::DrainState::over_wire;
    wired.access.in_duct_m = wired.access.wire_m = 0.040;
    wired.access.drain_m = 0.050 + haptics::kSideHoles_m;
    wired.tool = Tool::drain;
    Evidence evidence(patient_, test::wallPath(), test::kDt_s);
    evidence.setCourse(Course::drainage);
    TickOutput short_of = wired;
    short_of.access.drain_m = drain.access.drain_m;
    evidence.update(short_of, {}, fold_);
    EXPECT_EQ(evidence.missing(Step::drain), Refusal::drainLeaks) << "before the drain curls again";
    Progress step = progress();
    step.step = Step::drain, step.missing = Refusal::drainLeaks;
    EXPECT_EQ(nextAct(step, wired, {}), Act::shiftDrainIn);
    TickOutput at_end = wired;  // the drain cannot go beyond the wire
    at_end.access.wire_m = haptics::kSideHoles_m;
    EXPECT_EQ(nextAct(step, at_end, {}), Act::selectWire);
    at_end.tool = Tool::wire;
    EXPECT_EQ(nextAct(step, at_end, {}), Act::feedWire);
    step.missing = Refusal::drainTooDeep;
    EXPECT_EQ(nextAct(step, wired, {}), Act::shiftDrainOut);
    step.missing = Refusal::none;
    EXPECT_EQ(nextAct(step, letGo(wired), {}), Act::selectWire) << "to draw it out";
}

// A drain that is straightened again is no longer in its place. HZ-TEACH-25
TEST_F(DrainageTest, AStraightenedDrainMustBePlacedAnew) {
    TickOutput drain = letGo(withWire(0.040));
    drain.access.drain = haptics::DrainState::over_wire;
    update(drain, 100);
    curl(drain);
    update(drain, 10);
    EXPECT_TRUE(done(Step::drain));
    TickOutput straight = drain;
    straight.access.drain = haptics::DrainState::over_wire;
    procedure_.consumeEvents();
    update(straight, 10);
    EXPECT_FALSE(done(Step::drain) || done(Step::finalPicture));
    const std::vector<SessionEvent> events = procedure_.consumeEvents();
    ASSERT_EQ(events.size(), 1u) << "told once";
    EXPECT_EQ(events[0].kind, "refused");
    EXPECT_EQ(events[0].text, refusalText(Refusal::drainStraightened));
    EXPECT_EQ(progress().refusal, Refusal::drainStraightened);
    update(drain);
    EXPECT_TRUE(done(Step::drain));
    EXPECT_EQ(progress().out_of_order, 0u);
}

// The proof of the duct lasts for a wire through the drain, but not for another puncture. HZ-TEACH-25
TEST_F(DrainageTest, ADrainKeepsTheProofForItsOwnWireOnly) {
    const auto blind = [&] {
        return (progress().critical_errors & 1u << unsigned(CriticalError::blindWire)) != 0;
    };
    TickOutput in_duct = needleAt({0.053, 0, 0}, Tissue::duct, test::kDuctLabel), wire = in_duct;
    update(in_duct);
    EXPECT_EQ(draw(in_duct), Drawn::bile);
    wire.tool = Tool::wire;
    wire.access.open = wire.access.wire_in = wire.access.needle_in = true, wire.access.wire_m = 0.050;
    update(wire);
    TickOutput drain = outside();
    drain.access = wire.access;
    drain.access.needle_in = false;
    drain.access.drain = haptics::DrainState::over_wire;
    update(drain);
    TickOutput left = drain;
    left.access.open = left.access.wire_in = false;
    left.access.drain = haptics::DrainState::misplaced;
    update(left, 10);
    update(drain, 10);
    EXPECT_FALSE(blind()) << "through the drain";
    update(left, 10), update(in_duct, 10), update(wire);
    EXPECT_TRUE(blind()) << "through another needle";
}

// HZ-TEACH-25
TEST_F(DrainageTest, DrainForcedAheadOfTheDilatorTearsTheTrack) {
    TickOutput drain = withWire(0.040);
    drain.access.entry_m = Vec3(0.0);
    drain.tool = Tool::drain, drain.access.drain = haptics::DrainState::over_wire;
    update(drain);
    drain.access.drain_m = 0.010;
    update(drain);
    EXPECT_DOUBLE_EQ(progress().pain, kTearPain);
    EXPECT_EQ(progress().refusal, Refusal::trackTorn);
    // The debrief finds the tear by these words (app/report/advice.cpp).
    EXPECT_TRUE(refusalText(Refusal::trackTorn).starts_with("the drain tears"));
    EXPECT_NEAR(value(MetricId::tornTrack), 10.0, 1e-9);
    drain.access.drain_m = 0.080;
    update(drain, 10);
    EXPECT_NEAR(value(MetricId::tornTrack), 50.0, 1e-9) << "the track is 50 mm long; beyond it is the duct";
    drain.access.drain_m = 0.0;
    update(drain);
    drain.access.drain_m = 0.060;
    update(drain);
    EXPECT_NEAR(value(MetricId::tornTrack), 50.0, 1e-9) << "it is torn once";
    TickOutput closed = drain;
    closed.access.open = false;
    update(closed, 10);
    EXPECT_NEAR(value(MetricId::tornTrack), 50.0, 1e-9) << "a drain at rest tears nothing";
}

TEST_F(DrainageTest, DrainBehindTheDilatorTearsNothing) {
    update(withDilator(0.045));
    TickOutput drain = withWire(0.040);
    drain.tool = Tool::drain, drain.access.drain = haptics::DrainState::over_wire;
    drain.access.drain_m = 0.044;
    update(drain);
    EXPECT_EQ(value(MetricId::tornTrack), 0.0);
    EXPECT_EQ(progress().refusal, Refusal::notDilated) << "that is the dilator's";
    drain.access.drain_m = 0.060;
    update(drain);
    EXPECT_NEAR(value(MetricId::tornTrack), 5.0, 1e-9) << "the dilator had ended 5 mm before the duct";
    EXPECT_EQ(progress().refusal, Refusal::trackTorn);
}

// HZ-TEACH-25
TEST_F(DrainageTest, TutorAsksForBileAgainIfTheNeedleCameOutSinceTheProof) {
    Progress wants_wire;
    wants_wire.course = Course::drainage;
    wants_wire.step = Step::wire, wants_wire.missing = Refusal::wireUnproven;
    TickOutput now = needleAt({0.053, 0.0, 0.0}, Tissue::duct, 6);
    now.tool_awaits_exit = false;
    EXPECT_EQ(nextAct(wants_wire, now, {}), Act::aspirate);
    now.tool = Tool::wire, now.access.open = now.access.wire_in = now.access.needle_in = true;
    EXPECT_EQ(nextAct(wants_wire, now, {}), Act::pullWireBack)
        << "a needle that the wire fills draws no bile";
    now.tool = Tool::needle, now.access = {};
    wants_wire.missing = Refusal::none;
    EXPECT_EQ(nextAct(wants_wire, now, {}), Act::selectWire);
}

// A wire that was passed through the drain again is drawn out before medium is injected through it.
TEST_F(DrainageTest, TutorClearsTheDrainForTheFinalPicture) {
    Progress wants_picture;
    wants_picture.course = Course::drainage, wants_picture.step = Step::finalPicture;
    TickOutput now = withWire(0.040);
    now.tool_awaits_exit = false;
    now.access.drain = haptics::DrainState::in_place;
    now.tool = Tool::drain;
    EXPECT_EQ(nextAct(wants_picture, now, {}), Act::selectWire);
    now.tool = Tool::wire;
    EXPECT_EQ(nextAct(wants_picture, now, {}), Act::clearDrain);
    now.access.wire_in = false;
    EXPECT_EQ(nextAct(wants_picture, now, {}), Act::pressPedal);
}

// HZ-TEACH-25
TEST_F(DrainageTest, WireNeedsProofOfTheDuct) {
    TickOutput in_duct = needleAt({0.053, 0, 0}, Tissue::duct, test::kDuctLabel), wire = in_duct;
    wire.tool = Tool::wire;
    wire.access.open = wire.access.wire_in = wire.access.needle_in = true;
    const auto blind = [&] {
        return (progress().critical_errors & 1u << unsigned(CriticalError::blindWire)) != 0;
    };
    update(in_duct);
    EXPECT_EQ(draw(in_duct), Drawn::bile);
    update(outside());
    update(in_duct, 10), update(wire, 10);
    EXPECT_EQ(progress().refusal, Refusal::wireUnproven) << "that was another insertion";
    wire.access.wire_m = 0.009;
    update(wire);
    EXPECT_FALSE(blind());
    update(in_duct);
    EXPECT_EQ(draw(in_duct), Drawn::bile);
    wire.access.wire_m = 0.050;
    update(wire);
    EXPECT_FALSE(blind());
    wire.access.needle_in = false, wire.phase = haptics::Phase::outside;
    update(wire, 10);
    EXPECT_FALSE(blind()) << "the proof lasts as long as the access";
    update(outside(), 10), update(in_duct), update(wire);
    EXPECT_TRUE(blind());
    EXPECT_FALSE(passesIfWellDone());
}

// HZ-TEACH-25
TEST_F(DrainageTest, ExamIsFailedWithoutAnyOneOfItsParts) {
    EXPECT_TRUE(passesIfWellDone());
    for (const Step step : {Step::anaesthetise, Step::advance, Step::dilate, Step::drain, Step::finalPicture})
        EXPECT_FALSE(passesIfWellDone(kAllSteps & ~maskOf(step))) << stepName(step);
    for (const Step step :
         {Step::findGap, Step::findDuct, Step::incise, Step::guide, Step::aspirate, Step::contrast})
        EXPECT_TRUE(passesIfWellDone(kAllSteps & ~maskOf(step))) << stepName(step) << " costs points";
    EXPECT_FALSE(passesIfWellDone(kAllSteps & ~maskOf(Step::aspirate, Step::contrast))) << "no proof";
    EXPECT_EQ(missingParts(Course::drainage, kAllSteps & ~maskOf(Step::anaesthetise, Step::finalPicture)),
              (std::vector<std::string_view>{"local anaesthesia", "the final picture"}));
    EXPECT_EQ(missingParts(Course::puncture, 0).size(), 2u);
    EXPECT_TRUE(missingParts(Course::puncture, maskOf(Step::advance, Step::contrast)).empty());
}

TEST_F(DrainageTest, SyringeDrawsWhatIsAtTheNeedlesTip) {
    EXPECT_EQ(draw(needleAt({-0.01, 0, 0}, Tissue::air, 0)), Drawn::air);
    EXPECT_EQ(draw(liver(0.040)), Drawn::nothing);
    EXPECT_EQ(progress().refusal, Refusal::noBile);
    EXPECT_EQ(draw(vessel()), Drawn::blood);
    EXPECT_EQ(progress().refusal, Refusal::bloodDrawn);
    TickOutput in_duct = needleAt({0.053, 0, 0}, Tissue::duct, test::kDuctLabel);
    in_duct.access.wire_in = true;
    EXPECT_EQ(draw(in_duct), Drawn::nothing) << "the wire fills the needle";
    EXPECT_FALSE(done(Step::aspirate));
    in_duct.access.wire_in = false;
    EXPECT_EQ(draw(in_duct), Drawn::bile);
    EXPECT_TRUE(done(Step::aspirate));
}

TEST_F(DrainageTest, ALiftedProbeIsAimedAnewAlthoughTheSkinIsNumb) {
    update(finger({0.002, 0.0, 0.0}, 0.3), 400);
    TickOutput probe = parked(probeAt({0.0, 0.0, 0.0}, {1, 0, 0}));
    update(probe, 1100);
    EXPECT_EQ(progress().step, Step::anaesthetise);
    const auto withSyringe = [&](TickOutput out) {
        out.probe_parked = true, out.patient_from_probe = probe.patient_from_probe;
        return out;
    };
    update(withSyringe(outside()));
    numb(withSyringe(wall(0.004)), 0.6);
    update(withSyringe(outside()), 40);
    EXPECT_EQ(progress().missing, Refusal::capsuleNotNumb) << "the parked probe need not be aimed for it";
    update(outside(), 40);
    EXPECT_EQ(progress().missing, Refusal::ductBesideRail) << "the probe was lifted";
}

// The path's track and that of the parked probe's rail, 20 mm beside it.
TEST_F(DrainageTest, TheDepotShownIsOnTheTrackOfTheTip) {
    const auto withRail = [&](TickOutput out) {
        const Pose rail = wall(-0.010, 0.020).patient_from_needle;
        out.probe_parked = true;
        out.patient_from_probe = rail * haptics::GuideSettings{}.probe_from_guide.inverse();
        return out;
    };
    update(withRail(outside()));
    numb(withRail(wall(0.004)), 0.6);
    EXPECT_NEAR(progress().depot_m3, 0.6e-6, 1e-8);
    update(withRail(wall(0.004, 0.020)));
    EXPECT_EQ(progress().track_place, TrackPlace::skin);
    EXPECT_EQ(progress().depot_m3, 0.0) << "that lies on the other track";
    numb(withRail(wall(0.004, 0.020)), 0.2);
    EXPECT_NEAR(progress().depot_m3, 0.2e-6, 1e-8);
}

// The liver's capsule lies 22 mm deep.
TEST_F(DrainageTest, LocalAnaesthesiaNeedsTheSkinAndTheCapsule) {
    update(outside());
    numb(wall(0.004), 0.6);
    EXPECT_EQ(progress().track_place, TrackPlace::skin);
    EXPECT_FALSE(done(Step::anaesthetise));
    update(outside());
    EXPECT_EQ(progress().refusal, Refusal::capsuleNotNumb) << "the needle was drawn out too early";
    update(wall(0.010));
    EXPECT_EQ(progress().track_place, TrackPlace::wall);
    numb(wall(0.018), 2.1);
    EXPECT_EQ(progress().track_place, TrackPlace::capsule);
    EXPECT_NEAR(progress().depot_m3, 2.1e-6, 1e-8) << "only what lies here";
    EXPECT_EQ(progress().depot_wanted_m3, kCapsuleDepot_m3);
    EXPECT_TRUE(done(Step::anaesthetise));
    EXPECT_NEAR(value(MetricId::anaesthetic), 2.7, 0.01);
    EXPECT_EQ(value(MetricId::needlePath), 0.0) << "no travel of the puncture";
    EXPECT_EQ(value(MetricId::skinContacts), 0.0);
    update(liver(0.026));
    EXPECT_EQ(value(MetricId::skinContacts), 1.0) << "beyond the capsule it is a puncture";
    EXPECT_EQ(progress().critical_errors, 0u);
}

// HZ-TEACH-23
TEST_F(DrainageTest, LocalAnaesthesiaCannotBeFaked) {
    numb(outside(), 3.0);
    EXPECT_EQ(progress().refusal, Refusal::anaestheticLost) << "in the air";
    numb(wall(0.004), 5.0);
    update(outside());
    EXPECT_EQ(progress().refusal, Refusal::capsuleNotNumb) << "all in one place";
    numb(wall(0.018, 0.012), 3.0);
    EXPECT_EQ(progress().refusal, Refusal::anaestheticAside);
    numb(liver(0.030), 3.0);
    EXPECT_EQ(progress().refusal, Refusal::anaestheticBeyond) << "off the track's end, but in the liver";
    numb(vessel(), 1.0);
    EXPECT_EQ(progress().refusal, Refusal::anaestheticInVessel);
    EXPECT_FALSE(done(Step::anaesthetise));
    EXPECT_EQ(progress().critical_errors & 1u << unsigned(CriticalError::overdose), 0u);
}

TEST_F(DrainageTest, LocalAnaestheticBeyondTheCapsuleIsRefusedAsSuch) {
    update(outside());
    numb(wall(0.004), 0.6), update(outside()), update(wall(0.018));
    numb(liver(0.026), 0.2);
    EXPECT_EQ(progress().track_place, TrackPlace::beyond);
    EXPECT_NE(progress().refusal, Refusal::anaestheticBeyond) << "so little is not refused";
    numb(liver(0.026), 0.4);
    EXPECT_EQ(progress().refusal, Refusal::anaestheticBeyond);
    EXPECT_NE(refusalText(progress().refusal).find("beyond the liver's capsule"), std::string_view::npos);
    numb(wall(0.018, 0.012), 0.4);
    EXPECT_EQ(progress().refusal, Refusal::anaestheticAside) << "each injection has its own reason";
    EXPECT_FALSE(done(Step::anaesthetise)) << "it numbed neither";
    numb(wall(0.018), 2.1);
    EXPECT_TRUE(done(Step::anaesthetise));
}

// HZ-TEACH-23
TEST_F(DrainageTest, TooMuchLocalAnaestheticIsToldAndThenFails) {
    numb(wall(0.010), 20.5, 2e-6);
    EXPECT_EQ(progress().refusal, Refusal::tooMuchAnaesthetic);
    numb(outside(), 20.0, 2e-6);
    numb(wall(0.010), 9.0, 2e-6);
    EXPECT_TRUE(passesIfWellDone()) << "29.5 ml in the body; 20 ml outside it do not count";
    numb(wall(0.010), 1.0, 2e-6);
    EXPECT_FALSE(passesIfWellDone()) << "30.5 ml";
}

// HZ-TEACH-23
TEST_F(DrainageTest, LittleInAVesselIsTooMuch) {
    numb(vessel(), 4.9, 2e-6);
    EXPECT_TRUE(passesIfWellDone());
    numb(vessel(), 0.2, 2e-6);
    EXPECT_FALSE(passesIfWellDone());
}

// HZ-TEACH-23
TEST_F(DrainageTest, LocalAnaestheticInTissueAndVesselsAddsUp) {
    numb(wall(0.010), 26.0, 2e-6), numb(vessel(), 3.5, 2e-6);
    EXPECT_TRUE(passesIfWellDone());
    numb(vessel(), 1.0, 2e-6);
    EXPECT_FALSE(passesIfWellDone());
}

// S (1 - n) exp(-t / fade) of each stimulus.
TEST_F(DrainageTest, PainHasAClosedForm) {
    TickOutput cut;
    cut.tool = Tool::scalpel;
    cut.incision_count = 1, cut.cut_incision = 0;
    cut.newest_incision = cut.cut = {{0.0, -0.002, 0.0}, {0.0, 0.002, 0.0}};
    update(cut);
    EXPECT_DOUBLE_EQ(progress().pain, kIncisionPain);
    cut.cut_incision = -1;
    update(cut, 5000);
    EXPECT_NEAR(progress().pain, kIncisionPain * std::exp(-5.0 / kPainFade_s), 1e-9);
    EXPECT_DOUBLE_EQ(progress().worst_pain, kIncisionPain);
    update(outside());
    update(wall(0.001));
    EXPECT_NEAR(progress().pain, kIncisionPain * std::exp(-5.001 / kPainFade_s), 0.01) << "the prick is less";
    update(liver(0.022));
    EXPECT_DOUBLE_EQ(progress().pain, kCapsulePain);
    std::vector<SessionEvent> events = procedure_.consumeEvents();
    std::erase_if(events, [](const SessionEvent& e) { return e.kind != "pain"; });
    ASSERT_EQ(events.size(), 2u);
    EXPECT_EQ(events[0].text, "6 of 10: the incision");
    EXPECT_EQ(value(MetricId::pain), kCapsulePain);
}

TEST_F(DrainageTest, LocalAnaesthesiaTakesThePainOfItsPlace) {
    numb(wall(0.004), 1.0), update(outside());
    EXPECT_NEAR(progress().worst_pain, kSkinPrick, 0.02) << "the prick of the first needle";
    TickOutput cut;
    cut.tool = Tool::scalpel;
    cut.incision_count = 1, cut.cut_incision = 0;
    cut.newest_incision = cut.cut = {{0.001, -0.002, 0.0}, {0.001, 0.002, 0.0}};
    update(cut);
    EXPECT_NEAR(progress().worst_pain, kSkinPrick, 0.02) << "the incision is not felt";
    update(outside()), update(wall(0.010)), update(liver(0.0225));
    EXPECT_DOUBLE_EQ(progress().worst_pain, kCapsulePain) << "the capsule is";
}

TEST_F(DrainageTest, DilatationHurtsInTheWallOnly) {
    TickOutput dilator = withDilator(0.0);
    dilator.access.entry_m = Vec3(0.0);
    update(dilator);
    dilator.access.dilator_m = 0.010;
    update(dilator);
    EXPECT_DOUBLE_EQ(progress().pain, kDilatationPain);
    update(dilator, 10000);
    EXPECT_NEAR(progress().pain, kDilatationPain * std::exp(-1.0), 1e-3) << "lying there does not hurt";
    dilator.access.dilator_m = 0.030;
    update(dilator);
    EXPECT_NEAR(progress().pain, kDilatationPain * std::exp(-1.0), 1e-3) << "the liver does not hurt";
}

// What cannot be done any more is not asked for.
TEST_F(DrainageTest, StepsThatAreOutOfReachArePassedOver) {
    EXPECT_EQ(progress().step, Step::findGap);
    update(finger({0.002, 0.0, 0.0}, 0.3), 300);
    update(probeAt({0.0, 0.0, 0.0}, {1, 0, 0}), 1200);
    ASSERT_EQ(progress().step, Step::anaesthetise);
    numb(wall(0.004), 0.6), numb(wall(0.018), 2.1), update(outside());
    ASSERT_EQ(progress().step, Step::incise);
    TickOutput drain = letGo(withWire(0.040));
    curl(drain);
    update(drain);
    EXPECT_EQ(progress().step, Step::finalPicture);
    EXPECT_FALSE(done(Step::wire) && done(Step::dilate) && done(Step::advance));
}

}  // namespace
}  // namespace stylet::training
