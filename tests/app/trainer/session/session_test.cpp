#include "app/trainer/session/session.h"

#include <gtest/gtest.h>

#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

using haptics::EventRecord;
using haptics::NeedleEventKind;
using patient::Tissue;

haptics::TickRecord recordAt(std::uint64_t tick, double x_m, double force_n = 0.0) {
    haptics::TickRecord record;
    record.output.tick = tick;
    record.output.patient_from_needle.position_m = {x_m, 0.0, 0.0};
    record.output.tip_reference_m = {x_m, 0.0, 0.0};
    record.output.phase = x_m > 0.0 ? haptics::Phase::pass : haptics::Phase::outside;
    record.output.depth_m = x_m;
    record.output.force_n = force_n;
    return record;
}

EventRecord eventInto(Tissue tissue, NeedleEventKind kind, std::uint64_t tick) {
    EventRecord record;
    record.tick = tick;
    record.event.kind = kind;
    record.event.border.to = tissue;
    return record;
}

class SessionLogTest : public testing::Test {
  protected:
    patient::Package package_ = test::ductPhantom();
    patient::Patient patient_{package_};
    Session session_{patient_, test::ductPath(), {"approach", "duct"}, 0.005, nullptr};
};

TEST_F(SessionLogTest, ApproachIsTheFirstTickWithinItsDistanceOfTheSkin) {
    session_.update(recordAt(1, -0.0060));
    EXPECT_TRUE(session_.newCaptures().empty());
    session_.update(recordAt(2, -0.0049));
    session_.update(recordAt(3, -0.0040));
    const std::vector<Capture> captures = session_.newCaptures();
    ASSERT_EQ(captures.size(), 1u);
    EXPECT_EQ(captures[0].name, "approach");
    EXPECT_EQ(captures[0].state.tick.tick, 2u);
    EXPECT_TRUE(session_.newCaptures().empty());
}

TEST_F(SessionLogTest, EventIsMatchedToItsTickInAnyOrder) {
    session_.update(recordAt(1, -0.0060));
    session_.update(eventInto(Tissue::duct, NeedleEventKind::puncture, 2));
    EXPECT_TRUE(session_.newCaptures().empty()) << "its tick has not come yet";
    session_.update(recordAt(2, 0.0520));
    session_.update(recordAt(3, 0.0530));
    for (const Capture& m : session_.newCaptures())
        EXPECT_EQ(m.state.tick.tick, 2u) << m.name;
    ASSERT_EQ(session_.log().captures.size(), 2u);
    EXPECT_TRUE(session_.log().target_hit());
}

// HZ-TEACH-17
TEST_F(SessionLogTest, TargetHitNeedsACutAndTheTargetLabelAtTheTip) {
    session_.update(recordAt(1, 0.0300));
    // The event is in the duct, but the tip is in the liver.
    session_.update(eventInto(Tissue::duct, NeedleEventKind::puncture, 1));
    EXPECT_FALSE(session_.log().target_hit());
    session_.update(recordAt(2, 0.0520));
    session_.update(eventInto(Tissue::duct, NeedleEventKind::sideways, 2));
    session_.update(eventInto(Tissue::duct, NeedleEventKind::border, 2));
    session_.update(eventInto(Tissue::liver, NeedleEventKind::puncture, 2));
    EXPECT_FALSE(session_.log().target_hit());
    session_.update(eventInto(Tissue::duct, NeedleEventKind::puncture, 2));
    EXPECT_TRUE(session_.log().target_hit());
    EXPECT_EQ(session_.log().punctures.size(), 3u) << "cuts and entries only";
}

TEST_F(SessionLogTest, RecordsThePeakOfEitherSignAndTheCurveInsideTheBody) {
    session_.update(recordAt(1, -0.010, 0.0));
    session_.update(recordAt(2, 0.010, 1.5));
    session_.update(recordAt(3, 0.012, -2.5));
    EXPECT_DOUBLE_EQ(session_.log().peak_force_n, 2.5);
    ASSERT_EQ(session_.log().curve.size(), 2u);
    EXPECT_EQ(session_.log().curve[0].tick, 2u);
    ASSERT_TRUE(session_.log().deepest);
    EXPECT_EQ(session_.log().deepest->tick, 3u);
}

// A second cough during a cough is ignored by the ticks, and a second jerk during a jerk.
TEST_F(SessionLogTest, SaysWhyAnInjectedEventWasIgnored) {
    using enum haptics::CommandKind;
    const auto injectedAt = [&](std::uint64_t tick, haptics::CommandKind kind) {
        haptics::TickRecord record = recordAt(tick, -0.1);
        record.input.add({kind, 0});
        record.output.interruption = patient::InterruptionKind::cough;
        record.output.patient_moved_m = {0.001, 0.0, 0.0};
        session_.update(record);
        return session_.popInjected();
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(injectedAt(1, cough), Names{"cough"});
    EXPECT_EQ(injectedAt(2, cough), Names{"cough: not done, a cough is under way"});
    EXPECT_EQ(injectedAt(3, sigh), Names{"sigh: not done, a cough is under way"});
    EXPECT_EQ(injectedAt(4, move), Names{"move: not done, the patient is moving already"});
    session_.update(recordAt(5, -0.1));
    EXPECT_EQ(injectedAt(6, move), Names{"move"});
    session_.update(recordAt(7, -0.1));
    haptics::TickRecord both = recordAt(8, -0.1);
    for (const haptics::CommandKind kind : {cough, cough, move, move})
        both.input.add({kind, 0});
    session_.update(both);
    EXPECT_EQ(session_.popInjected(), (Names{"cough", "cough: not done, a cough is under way", "move",
                                             "move: not done, the patient is moving already"}))
        << "in the same tick";
}

// The syringe's scale is shown while it injects and for 3 s after.
TEST_F(SessionLogTest, ReadsTheSyringesScale) {
    std::uint64_t tick = 0;
    const auto step = [&](int ticks, std::optional<haptics::Command> command = {}) {
        for (int i = 0; i < ticks; ++i) {
            haptics::TickRecord record = recordAt(++tick, -0.02);
            if (command && i == 0) record.input.add(*command);
            session_.update(record);
        }
        return session_.frameState(*session_.newest()).syringe;
    };
    EXPECT_FALSE(step(10));
    const auto runs = step(1500, training::anaesthetiseCommand(1e-6));
    ASSERT_TRUE(runs);
    EXPECT_TRUE(runs->anaesthetic);
    EXPECT_NEAR(runs->injected_m3, 1.5e-6, 1e-9);
    const auto stopped = step(2900, training::anaesthetiseCommand(0.0));
    ASSERT_TRUE(stopped);
    EXPECT_NEAR(stopped->injected_m3, 1.5e-6, 2e-9);
    EXPECT_FALSE(step(200));
    const auto contrast = step(500, training::injectCommand(1e-6));
    ASSERT_TRUE(contrast);
    EXPECT_FALSE(contrast->anaesthetic);
    EXPECT_NEAR(contrast->injected_m3, 0.5e-6, 1e-9);
}

TEST_F(SessionLogTest, SaysForAWhileThatAnotherAttemptWasRefused) {
    session_.setStartRefused("no");
    session_.update(recordAt(1, -0.02));
    EXPECT_EQ(session_.frameState(*session_.newest()).start_refused, "no");
    session_.update(recordAt(25'000, -0.02));
    EXPECT_EQ(session_.frameState(*session_.newest()).start_refused, "");
}

// An exam that was made easier for a while is not an exam.
// HZ-TEACH-12
TEST(Session, EasiestDifficultyCounts) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    Session session(patient, test::ductPath(), {}, 0.0, nullptr);
    session.setDifficulty(training::Difficulty::exam);
    EXPECT_EQ(session.easiestDifficulty(), training::Difficulty::exam);
    session.setDifficulty(training::Difficulty::practice);
    session.setDifficulty(training::Difficulty::exam);
    EXPECT_EQ(session.difficulty(), training::Difficulty::exam);
    EXPECT_EQ(session.easiestDifficulty(), training::Difficulty::practice);
}

}  // namespace
}  // namespace stylet::trainer
