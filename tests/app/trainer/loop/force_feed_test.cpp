#include "app/trainer/loop/force_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/trainer/loop/loops.h"
#include "base/rings.h"
#include "haptics/devices/replay.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

using haptics::CommandKind;
using haptics::ForceStage;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDt_s = 0.001;

struct Feed : testing::Test {
    // Runs `count` identical ticks.
    void ticks(int count, std::uint32_t faults, std::uint32_t awaited, std::uint32_t buttons = 0) {
        for (int i = 0; i < count; ++i) {
            haptics::TickRecord record;
            record.input.device.buttons = buttons;
            record.output.tick = ++tick_;
            record.output.faults = faults;
            record.output.awaited = awaited;
            record.output.stage = faults != 0 ? ForceStage::off : ForceStage::on;
            session.update(record);
        }
        feed.update(true, session, ring);
    }
    std::vector<std::uint32_t> asked() {
        std::vector<std::uint32_t> kinds;
        for (haptics::Command c; ring.pop(c);)
            kinds.push_back(std::uint32_t(c.kind));
        return kinds;
    }
    std::vector<std::string> heard() { return std::exchange(said, {}); }

    patient::Package package = test::ductPhantom();
    patient::Patient patient{package};
    Session session{patient, test::ductPath(), {}, 0.0, nullptr};
    Ring<haptics::Command> ring{4};
    std::vector<std::string> said;
    ForceFeed feed{true, kDt_s, nullptr, [this](const std::string& text) { said.push_back(text); }};

  private:
    std::uint64_t tick_ = 0;
};

TEST_F(Feed, FaultIsReportedOnceAndAgainAfterRearming) {
    ticks(10, 0, 0);
    EXPECT_THAT(heard(), IsEmpty());
    ticks(10, haptics::kFaultHandOff, 0);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("no hand holds the device")));
    ticks(10, haptics::kFaultHandOff, 0);
    EXPECT_THAT(heard(), IsEmpty());
    ticks(10, haptics::kFaultHandOff | haptics::kFaultStaleInput, 0);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("no new data")));
    ticks(10, 0, 0);  // re-armed
    ticks(10, haptics::kFaultHandOff, 0);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("no hand holds the device")));
}

TEST_F(Feed, FaultBetweenTwoUpdatesIsReported) {
    for (const std::uint32_t faults : {0u, std::uint32_t(haptics::kFaultOverSpeed), 0u}) {
        haptics::TickRecord record;
        record.output.faults = faults;
        session.update(record);
    }
    feed.update(true, session, ring);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("faster than 1 m/s")));
}

TEST_F(Feed, LongWaitForForceIsReported) {
    ticks(900, 0, haptics::kWaitsForSmallForce);
    EXPECT_THAT(heard(), IsEmpty());
    ticks(200, 0, haptics::kWaitsForSmallForce);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("force paused: the tool touches the patient")));
    ticks(5000, 0, haptics::kWaitsForSmallForce);
    EXPECT_THAT(heard(), IsEmpty());
    ticks(1100, 0, haptics::kFaultHandOff | haptics::kFaultStaleInput);
    EXPECT_THAT(heard(), ElementsAre(testing::AllOf(HasSubstr("no hand"), HasSubstr("no new data"))));
    ticks(1, 0, 0);
    ticks(1100, 0, haptics::kWaitsForSmallForce);
    EXPECT_EQ(heard().size(), 1u);
}

// HZ-FORCE-08
TEST_F(Feed, TheRearmingButtonCountsWhileTheForceIsOff) {
    ticks(1, 0, 0);
    ticks(5, 0, 0, 1);
    ticks(5, haptics::kFaultHandOff, 0, 1);  // the button stays pressed
    EXPECT_THAT(asked(), IsEmpty());
    ticks(5, haptics::kFaultHandOff, 0, 0);
    ticks(5, haptics::kFaultHandOff, 0, 1);
    EXPECT_THAT(asked(), ElementsAre(std::uint32_t(CommandKind::rearm)));
}

struct LiveFeed : Feed {
    std::string typed;
    std::vector<haptics::Tool> tools_set;
    haptics::Trace trace{{{}}, {}};
    haptics::ReplayDevice device{trace, 0};
    LiveHand live{device,
                  {},
                  [this] { return std::exchange(typed, {}); },
                  [this](haptics::Tool tool) { tools_set.push_back(tool); },
                  {},
                  "Enter here"};
    ForceFeed feed_of_live{true, kDt_s, &live, [this](const std::string& text) { said.push_back(text); }};
};

// Without any picture: the case and its questions are printed, and typed words answer.
TEST_F(LiveFeed, PrintsTheCaseOnceAndEachQuestion) {
    session.setCourse(training::Course::drainage);
    session.setCase(std::make_shared<const training::PatientCase>(
        training::loadCase(test::assets() / "cases" / "clean.toml")));
    ticks(1, 0, 0);
    heard(), asked();
    feed_of_live.update(true, session, ring);
    const std::vector<std::string> first = heard();
    ticks(500, 0, 0);
    EXPECT_THAT(first, testing::Contains(HasSubstr("INR 1.1")));
    EXPECT_THAT(first.back(), HasSubstr("question 1 of 7: Must the clotting"));
    typed = "no\n";
    feed_of_live.update(true, session, ring);
    EXPECT_THAT(heard(), IsEmpty());
    EXPECT_THAT(asked(), ElementsAre(std::uint32_t(CommandKind::answer)));
    haptics::TickRecord record;
    record.input.add(training::kNo);
    record.output.tick = 502;
    session.update(record);
    feed_of_live.update(true, session, ring);
    const std::vector<std::string> second = heard();
    EXPECT_THAT(second, testing::Contains(HasSubstr("question 2 of 7")));
    EXPECT_THAT(second, testing::Not(testing::Contains(HasSubstr("INR 1.1"))));
}

// Words that make no sense to a user of a mouse or a controller.
testing::Matcher<const std::string&> speaksOfForce() {
    return testing::AnyOf(HasSubstr("force"), HasSubstr("re-arm"), HasSubstr("rearm"), HasSubstr("home"),
                          HasSubstr("headset is off"));
}

// A mouse in place of the haptic device.
struct InputOnlyFeed : LiveFeed {
    haptics::ReplayDevice mouse{trace, 0, haptics::inputOnlyProfile("mouse", "input only")};
    LiveHand mouse_hand{mouse, {}, live.typed, live.set_tool, {.rearm = 0}, ""};
    ForceFeed mouse_feed{true, kDt_s, &mouse_hand, [this](const std::string& text) { said.push_back(text); }};
};

TEST_F(InputOnlyFeed, HearsNothingOfForce) {
    ticks(1, 0, 0);
    heard(), asked();
    for (const haptics::FaultText& fault : haptics::faultTexts()) {
        if (fault.bit == haptics::kFaultRingFull) continue;
        ticks(1, 0, 0);
        heard();
        for (int i = 0; i < 2000; ++i) {
            haptics::TickRecord record;
            record.output.tick = 1'000'000u + std::uint64_t(i);
            record.output.faults = record.output.awaited = fault.bit;
            session.update(record);
        }
        mouse_feed.update(true, session, ring);
        mouse_feed.update(false, session, ring, true);
        EXPECT_THAT(heard(), testing::Each(testing::Not(speaksOfForce()))) << fault.name;
    }
    asked();
    typed = "\nrearm\nhelp\n";
    mouse_feed.update(true, session, ring);
    EXPECT_THAT(asked(), testing::Not(testing::Contains(std::uint32_t(CommandKind::rearm))));
    const std::vector<std::string> help = heard();
    ASSERT_EQ(help.size(), 1u);
    EXPECT_THAT(help[0], HasSubstr("breathe"));
    EXPECT_THAT(help[0], testing::Not(speaksOfForce()));
    EXPECT_THAT(describeCommands(), HasSubstr("re-arm")) << "for the others";
}

// To the loop a stalled picture is a lost focus. The user is told what it is.
TEST_F(LiveFeed, AStalledPictureIsNotCalledALostFocus) {
    ticks(1, 0, 0);
    heard();
    haptics::TickRecord record;
    record.output.tick = 1'000'000;
    record.output.faults = haptics::kFaultNotFocused;
    session.update(record);
    feed_of_live.update(false, session, ring, true);
    EXPECT_THAT(heard(), ElementsAre("force off: the picture has stopped; re-arm with Enter here"));
    record.output.faults = 0;
    session.update(record);
    record.output.faults = haptics::kFaultNotFocused;
    session.update(record);
    feed_of_live.update(false, session, ring, false);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("headset is off")));
}

TEST_F(LiveFeed, CommandsWaitForSpaceInTheRing) {
    typed = "hold\nbreathe\nhold\nbreathe\nhold\nbreathe\nnonsense\n";
    feed_of_live.update(true, session, ring);
    EXPECT_THAT(asked(), IsEmpty()) << "before the first tick nothing is known";
    ticks(1, 0, 0);
    feed_of_live.update(true, session, ring);
    EXPECT_EQ(asked().size(), 4u);
    feed_of_live.update(true, session, ring);
    EXPECT_EQ(asked().size(), 2u);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("nonsense")));
    EXPECT_THAT(tools_set, ElementsAre(haptics::Tool::needle, haptics::Tool::needle));
}

// If tracking is lost while the pedal's button is pressed, the pedal is released.
TEST_F(LiveFeed, LostDeviceReportsNoButtons) {
    LiveHand hand = live;
    hand.buttons = {.pedal = 8};
    ForceFeed feet{true, kDt_s, &hand, {}};
    std::uint64_t tick = 0;
    for (const std::uint32_t flags : {std::uint32_t(haptics::kDeviceReady), 0u}) {
        haptics::TickRecord record;
        record.input.device.buttons = 8;
        record.input.device.flags = flags;
        record.output.tick = ++tick;
        session.update(record);
        feet.update(true, session, ring);
        haptics::Command said_now;
        ASSERT_TRUE(ring.pop(said_now));
        EXPECT_EQ(said_now.kind, CommandKind::pedal);
        EXPECT_EQ(said_now.value, flags != 0 ? 1u : 0u);
        EXPECT_TRUE(ring.empty());
    }
}

// A controller moves the tool to the skin while its trigger is held. A tap places nothing.
TEST_F(LiveFeed, ATappedTriggerIsNotSaidToPlaceTheTool) {
    LiveHand controller = live;
    controller.buttons = {.rearm = 0, .snap = 1};
    session.setRearmButton(0);
    std::string why_not;
    controller.snap = [&](const haptics::TickOutput&) { return why_not; };
    ForceFeed controller_feed{true, kDt_s, &controller,
                              [this](const std::string& text) { said.push_back(text); }};
    std::uint64_t tick = 0;
    const auto saidAfter = [&](std::vector<std::uint32_t> buttons, double touching_share = 0.0) {
        for (const std::uint32_t down : buttons) {
            haptics::TickRecord record;
            record.input.device.flags = haptics::kDeviceReady;
            record.input.device.buttons = down;
            record.output.tick = ++tick;
            record.output.probe_touching_share = touching_share;
            session.update(record);
        }
        controller_feed.update(true, session, ring);
        return heard();
    };
    saidAfter({0});
    EXPECT_THAT(saidAfter({1}), ElementsAre("the tool moves to the skin while you hold the trigger"));
    EXPECT_THAT(saidAfter({1, 0}), IsEmpty());
    EXPECT_THAT(saidAfter({1, 0}),
                ElementsAre("not placed on the skin: hold the trigger until the tool is there"));
    EXPECT_THAT(saidAfter({1, 0}, 0.5), ElementsAre("the tool moves to the skin"))
        << "a tool that touches the patient stays there";
    typed = "skin\n";
    EXPECT_THAT(saidAfter({0}), ElementsAre(HasSubstr("hold the trigger")));
    why_not = "there is no skin beneath the tool";
    EXPECT_THAT(saidAfter({1, 0}), ElementsAre("not placed on the skin: there is no skin beneath the tool"));
}

// What the window shows.
struct AnsweredFeed : LiveFeed {
    std::string shown() const { return session.frameState(*session.newest()).answer; }
    // The next tick executes all commands in the ring. Returns how many there were.
    std::uint32_t tick(ForceFeed& by) {
        by.update(true, session, ring);
        haptics::TickRecord record;
        for (haptics::Command c; ring.pop(c);)
            record.input.add(c);
        record.output.tick = session.newest()->tick + 1;
        session.update(record);
        by.update(true, session, ring);
        return record.input.command_count;
    }
    haptics::ReplayDevice mouse{trace, 0, haptics::inputOnlyProfile("mouse", "input only")};
    LiveHand mouse_hand{mouse, {}, live.typed, live.set_tool, {.rearm = 0}, ""};
    ForceFeed mouse_feed{true, kDt_s, &mouse_hand, [this](const std::string& text) { said.push_back(text); }};
};

// HZ-TEACH-12
TEST_F(AnsweredFeed, AnInstructorsEventWithoutEffectIsReportedWithTheReason) {
    ticks(1, 0, 0);
    heard(), asked();
    typed = "bleed\n";
    EXPECT_EQ(tick(mouse_feed), 1u);
    EXPECT_THAT(heard(), ElementsAre("instructor: bleed: no hole is in the skin"));
    EXPECT_EQ(shown(), "instructor: bleed: no hole is in the skin");
    typed = "fault\n";
    EXPECT_EQ(tick(mouse_feed), 0u) << "not executed, and not in the record";
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("instructor: fault: not done")));
    EXPECT_THAT(shown(), HasSubstr("instructor: fault: not done"));
    typed = "fault\n";
    EXPECT_EQ(tick(feed_of_live), 1u) << "a haptic device";
    EXPECT_THAT(heard(), testing::Contains("instructor: fault"));
    typed = "pause\ncough\n";
    mouse_feed.update(true, session, ring);
    EXPECT_THAT(heard(), ElementsAre("instructor: cough: waits until the attempt resumes",
                                     "instructor: pause: paused"));
    ticks(int(7.0 / kDt_s), 0, 0);
    EXPECT_EQ(shown(), "") << "an answer disappears";
}

TEST_F(AnsweredFeed, TheWindowShowsTheAnswerToATypedCommand) {
    ticks(1, 0, 0);
    typed = "nonsense\n";
    tick(mouse_feed);
    EXPECT_THAT(shown(), HasSubstr("\"nonsense\" is not a command"));
    typed = "aspirate\n";
    EXPECT_EQ(tick(mouse_feed), 0u);
    EXPECT_THAT(shown(), HasSubstr("needs a needle in the body"));
    typed = "new seed 7\n";
    tick(mouse_feed);
    EXPECT_EQ(shown(), "instructor: the next attempt has seed 7");
    typed = "help\n";
    tick(mouse_feed);
    EXPECT_EQ(shown(), "the list is on the terminal");
}

// A script controls the tools, so only the instructor can command anything.
TEST_F(AnsweredFeed, AScriptedAttemptAnswersAnUnknownCommand) {
    std::string console = "probe\nnonsense\n";
    ForceFeed scripted{true, kDt_s, nullptr, [this](const std::string& text) { said.push_back(text); },
                       [&] { return std::exchange(console, {}); }};
    ticks(1, 0, 0);
    EXPECT_EQ(tick(scripted), 0u);
    EXPECT_THAT(heard(), ElementsAre(HasSubstr("\"probe\" is not an instructor's command")));
    EXPECT_THAT(shown(), HasSubstr("\"probe\" is not an instructor's command"));
    console = "\n\n";
    tick(scripted);
    EXPECT_THAT(heard(), IsEmpty());
}

// Replaces the haptics loop. Every tick pops the commands in the ring and applies changes of the tool.
struct ToolFeed : LiveFeed {
    // Returns the number of commands popped.
    std::uint32_t tick() {
        haptics::TickRecord record;
        for (haptics::Command c; record.input.command_count < haptics::kMaxCommandsPerTick && ring.pop(c);) {
            record.input.commands[record.input.command_count++] = c;
            if (c.kind == CommandKind::tool) tool = haptics::Tool(c.value);
        }
        record.output.tick = ++ticked;
        record.output.tool = tool;
        session.update(record);
        return record.input.command_count;
    }
    haptics::Tool tool = haptics::Tool::needle;
    std::uint64_t ticked = 0;
};

TEST_F(ToolFeed, EachToolChangeIsReportedSeparately) {
    typed = "finger\nnext\nscalpel\n";
    tick();
    for (int i = 0; i < 6; ++i) {
        feed_of_live.update(true, session, ring);
        EXPECT_LE(tick(), 1u);
    }
    feed_of_live.update(true, session, ring);
    EXPECT_THAT(heard(),
                ElementsAre("the finger is in hand", "the probe is in hand", "the scalpel is in hand"));
}

TEST_F(ToolFeed, TickWithoutTheCommandDoesNotCompleteIt) {
    typed = "finger\nscalpel\n";
    tick();
    feed_of_live.update(true, session, ring);
    ticks(3, 0, 0);  // ticks that began before the command arrived
    feed_of_live.update(true, session, ring);
    EXPECT_EQ(tick(), 1u);
    feed_of_live.update(true, session, ring);
    feed_of_live.update(true, session, ring);
    EXPECT_EQ(tick(), 1u);
}

TEST_F(ToolFeed, LostRecordOfAToolChangeTimesOut) {
    typed = "finger\nscalpel\n";
    tick();
    feed_of_live.update(true, session, ring);
    EXPECT_EQ(asked().size(), 1u);
    for (int i = 0; i < 1000; ++i)
        tick();
    feed_of_live.update(true, session, ring);
    EXPECT_EQ(asked().size(), 1u);
}

TEST_F(ToolFeed, InputIsNotReadAheadOfUse) {
    tick();
    std::string many;
    while (many.size() < 20'000)
        many += "finger\n";
    for (int i = 0; i < 4; ++i) {
        typed = many;
        feed_of_live.update(true, session, ring);
        EXPECT_EQ(typed.empty(), i < 2) << "one for the user, one that waits";
    }
}

}  // namespace
}  // namespace stylet::trainer
