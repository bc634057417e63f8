#include "app/trainer/attempt/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "app/training/equipment.h"

namespace stylet::trainer {
namespace {

using haptics::CommandKind;
using haptics::TickOutput;
using haptics::Tool;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

MATCHER_P2(Asks, kind, value, "") {
    return arg.kind == kind && arg.value == std::uint32_t(value);
}

struct UserCommandsTest : testing::Test {
    std::vector<haptics::Command> typed(std::string_view text) { return user.update(text, 0, now); }
    std::vector<haptics::Command> pressed(std::uint32_t buttons) { return user.update("", buttons, now); }
    std::vector<std::string> said;
    UserCommands user{{.rearm = 1, .next = 2, .breath = 8},
                      [this](const std::string& text) { said.push_back(text); }};
    TickOutput now;
};

TEST_F(UserCommandsTest, CompleteLinesBecomeCommands) {
    EXPECT_THAT(typed("finger\n"), ElementsAre(Asks(CommandKind::tool, Tool::finger)));
    EXPECT_THAT(typed("probe\n"), ElementsAre(Asks(CommandKind::tool, Tool::probe)));
    EXPECT_THAT(typed("scalpel\n"), ElementsAre(Asks(CommandKind::tool, Tool::scalpel)));
    EXPECT_THAT(typed(" guide \r\n"), ElementsAre(Asks(CommandKind::tool, Tool::guide)));
    EXPECT_THAT(typed("park\n"), ElementsAre(Asks(CommandKind::park, 1)));
    EXPECT_THAT(typed("lift\n"), ElementsAre(Asks(CommandKind::park, 0)));
    EXPECT_THAT(typed("hold\nbreathe\nrearm\n\n"),
                ElementsAre(Asks(CommandKind::holdBreath, 0), Asks(CommandKind::breathe, 0),
                            Asks(CommandKind::rearm, 0), Asks(CommandKind::rearm, 0)));
    EXPECT_THAT(typed("nee"), IsEmpty());
    EXPECT_THAT(typed("dle"), IsEmpty());
    EXPECT_THAT(typed("\n"), ElementsAre(Asks(CommandKind::tool, Tool::needle)));
    EXPECT_THAT(said, IsEmpty());
}

TEST_F(UserCommandsTest, ToolChangesAreSentOneAtATime) {
    EXPECT_THAT(typed("hold\nfinger\nrearm\nprobe\nsca"),
                ElementsAre(Asks(CommandKind::holdBreath, 0), Asks(CommandKind::tool, Tool::finger)));
    EXPECT_TRUE(user.hasLine());
    now.tool = Tool::finger;
    EXPECT_THAT(pressed(2 | 8),
                ElementsAre(Asks(CommandKind::rearm, 0), Asks(CommandKind::tool, Tool::probe)));
    EXPECT_FALSE(user.hasLine());
    now.tool = Tool::probe;
    EXPECT_THAT(typed(""), ElementsAre(Asks(CommandKind::breathe, 0), Asks(CommandKind::park, 1)))
        << "buttons wait too";
}

TEST_F(UserCommandsTest, NextTwiceSelectsTheSecondTool) {
    now.tool = Tool::scalpel;
    EXPECT_THAT(typed("next\nnext\n"), ElementsAre(Asks(CommandKind::tool, Tool::guide)));
    now.tool = Tool::guide;
    EXPECT_THAT(typed(""), ElementsAre(Asks(CommandKind::tool, Tool::needle)));
    EXPECT_THAT(typed(""), IsEmpty());
}

TEST_F(UserCommandsTest, UnknownCommandsAreReportedAndIgnored) {
    EXPECT_THAT(typed("needles\n"), IsEmpty());
    ASSERT_EQ(said.size(), 1u);
    EXPECT_THAT(said[0], HasSubstr("\"needles\""));
    // An endless line does not use unlimited memory.
    for (int i = 0; i < 1000; ++i)
        EXPECT_THAT(typed(std::string(1000, 'x')), IsEmpty());
    EXPECT_THAT(typed("\npark\n"), ElementsAre(Asks(CommandKind::park, 1)));
    ASSERT_EQ(said.size(), 2u);
    EXPECT_LT(said[1].size(), 200u);
}

TEST_F(UserCommandsTest, EquipmentCommandsNeedANumber) {
    user.setCourse(training::Course::drainage);
    now.phase = haptics::Phase::pass, now.tissue = haptics::Tissue::duct;
    EXPECT_THAT(
        typed("pedal\nrelease\nstop\n"),
        ElementsAre(Asks(CommandKind::pedal, 1), Asks(CommandKind::pedal, 0), Asks(CommandKind::inject, 0)));
    EXPECT_THAT(typed("inject\ninject 2.5\ninject\t 20\n"),
                ElementsAre(Asks(CommandKind::inject, 1000), Asks(CommandKind::inject, 2500),
                            Asks(CommandKind::inject, 20000)));
    EXPECT_THAT(said, IsEmpty());
    for (const training::Machine machine : {training::Machine::xray, training::Machine::ultrasound})
        for (std::size_t i = 0; i < training::machineKnobs(machine).size(); ++i) {
            const training::Knob& knob = training::machineKnobs(machine)[i];
            const std::vector<haptics::Command> asked =
                typed(std::string(knob.word) + " " + std::to_string(knob.high) + "\n");
            ASSERT_EQ(asked.size(), 1u) << knob.word;
            EXPECT_NEAR(training::decodeKnobCommand(asked[0])->value, knob.high, 1e-9) << knob.word;
            EXPECT_EQ(training::decodeKnobCommand(asked[0])->machine, machine);
            EXPECT_THAT(describeOutcome(asked[0], now, now), HasSubstr(std::string(knob.word) + " "));
        }
    EXPECT_THAT(typed("numb\nnumb 0.5\n"),
                ElementsAre(Asks(CommandKind::anaesthetic, 1000), Asks(CommandKind::anaesthetic, 500)));
    EXPECT_EQ(describeOutcome({CommandKind::inject, 1500}, now, now), "contrast medium, 1.5 ml/s");
    EXPECT_EQ(describeOutcome({CommandKind::anaesthetic, 500}, now, now), "local anaesthetic, 0.5 ml/s");
    EXPECT_EQ(describeOutcome(training::kAspirate, now, now), "the syringe draws bile");
    EXPECT_THAT(said, IsEmpty());
    EXPECT_THAT(
        typed("inject 21\ninject -1\ninject nan\ninject 1x\nrotate\nrotate 400\ngain +\nturn 3\nnumb 2.1\n"),
        IsEmpty());
    ASSERT_EQ(said.size(), 9u);
    EXPECT_THAT(said[0], HasSubstr("from 0 to 20"));
    EXPECT_THAT(said[5], HasSubstr("from -90 to 90"));
    EXPECT_THAT(said[7], HasSubstr("is not a command"));
}

// A puncture has no local anaesthesia.
TEST_F(UserCommandsTest, NumbIsACommandOfADrainageOnly) {
    EXPECT_THAT(typed("numb\nnumb 0.5\nhelp\n"), IsEmpty());
    ASSERT_EQ(said.size(), 3u);
    EXPECT_THAT(said[0], HasSubstr("part of a drainage"));
    EXPECT_THAT(said[1], HasSubstr("part of a drainage"));
    EXPECT_THAT(said[2], testing::Not(HasSubstr("numb")));
    EXPECT_THAT(said[2], testing::Not(HasSubstr("anaesthetic")));
    said.clear();
    user.setCourse(training::Course::drainage);
    now.phase = haptics::Phase::pass;
    EXPECT_THAT(typed("numb\nhelp\n"), ElementsAre(Asks(CommandKind::anaesthetic, 1000)));
    ASSERT_EQ(said.size(), 1u);
    EXPECT_THAT(said[0], HasSubstr("  numb N "));
    const UserButtons buttons{.inject = 1};
    EXPECT_THAT(describe(buttons), testing::Not(HasSubstr("anaesthetic")));
    EXPECT_THAT(describe(buttons, {}, training::Course::drainage), HasSubstr("local anaesthetic until"));
}

// Like the wire. A refused command is not executed, so nothing is recorded and scored.
TEST_F(UserCommandsTest, ASyringeNeedsANeedleInTheBody) {
    user.setCourse(training::Course::drainage);
    now.tool = Tool::probe;
    EXPECT_THAT(typed("aspirate\ninject\nnumb\n"), IsEmpty());
    ASSERT_EQ(said.size(), 3u);
    EXPECT_THAT(said, testing::Each(HasSubstr("needs a needle in the body")));
    EXPECT_THAT(typed("stop\ninject 0\n"),
                ElementsAre(Asks(CommandKind::inject, 0), Asks(CommandKind::inject, 0)))
        << "an injection can always be stopped";
    // A needle that only dents the skin is not in the body. Local anaesthetic makes a wheal there.
    now.tool = Tool::needle, now.phase = haptics::Phase::tenting, now.tissue = haptics::Tissue::air;
    EXPECT_THAT(typed("aspirate\ninject\nnumb\n"), ElementsAre(Asks(CommandKind::anaesthetic, 1000)));
    now.depth_m = 0.03;  // in the lung
    EXPECT_THAT(typed("aspirate\n"), ElementsAre(Asks(CommandKind::aspirate, 0)));
    now.depth_m = 0.0, now.tissue = haptics::Tissue::skin;
    EXPECT_THAT(typed("aspirate\ninject\n"),
                ElementsAre(Asks(CommandKind::aspirate, 0), Asks(CommandKind::inject, 1000)));
    // Contrast medium also flows through a drain.
    now = {};
    now.access.drain = haptics::DrainState::in_place;
    said.clear();
    EXPECT_THAT(typed("aspirate\ninject\nnumb\n"), ElementsAre(Asks(CommandKind::inject, 1000)));
    EXPECT_EQ(said.size(), 2u);
}

// What a key has started may have been refused, so the key does not know whether to start or stop.
TEST_F(UserCommandsTest, TheKeyOfASyringeStopsWhatFlows) {
    user.setCourse(training::Course::drainage);
    EXPECT_THAT(typed("inject or stop\n"), IsEmpty()) << "no needle";
    now.tool = Tool::needle, now.phase = haptics::Phase::pass, now.tissue = haptics::Tissue::soft;
    EXPECT_THAT(typed("inject or stop\ninject or stop\n"),
                ElementsAre(Asks(CommandKind::inject, 1000), Asks(CommandKind::inject, 0)));
    EXPECT_THAT(typed("numb or stop\ninject or stop\nnumb or stop\nstop\ninject or stop\n"),
                ElementsAre(Asks(CommandKind::anaesthetic, 1000), Asks(CommandKind::inject, 0),
                            Asks(CommandKind::anaesthetic, 1000), Asks(CommandKind::inject, 0),
                            Asks(CommandKind::inject, 1000)));
}

TEST_F(UserCommandsTest, AButtonStopsOnlyTheInjectionThatItHasStarted) {
    UserCommands device{{.inject = 1, .aspirate = 2},
                        [this](const std::string& text) { said.push_back(text); }};
    EXPECT_THAT(device.update("", 2, now, 1), IsEmpty());
    EXPECT_THAT(said, testing::Each(HasSubstr("needs a needle in the body")));
    EXPECT_EQ(said.size(), 2u);
    EXPECT_THAT(device.update("", 0, now, 0), IsEmpty()) << "nothing flows";
    now.phase = haptics::Phase::pass;
    EXPECT_THAT(device.update("", 0, now, 1), ElementsAre(Asks(CommandKind::inject, 1000)));
    EXPECT_THAT(device.update("", 0, now, 0), ElementsAre(Asks(CommandKind::inject, 0)));
}

// While a question is open, two buttons answer it. Otherwise they do what they always do.
TEST_F(UserCommandsTest, ButtonsAndWordsAnswerOnlyAnOpenQuestion) {
    EXPECT_THAT(typed("yes\nno\n"), IsEmpty());
    ASSERT_EQ(said.size(), 2u);
    EXPECT_EQ(said[0], "no question is open");
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::holdBreath, 0)));
    const auto ask = [this](int question) {
        user.setQuestion(question);
        pressed(0);
        now.tick += 500;
    };
    ask(0);
    EXPECT_THAT(typed(" yes \n"), ElementsAre(Asks(CommandKind::answer, 1)));
    ask(1);
    EXPECT_THAT(typed("no\n"), ElementsAre(Asks(CommandKind::answer, 0)));
    ask(2);
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::answer, 1)));
    ask(3);
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::answer, 0)));
    ask(4);
    EXPECT_THAT(pressed(8 | 2), IsEmpty()) << "neither";
    EXPECT_EQ(describeOutcome(training::kNo, now, now), "answered: no");
    user.setQuestion(std::nullopt);
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::breathe, 0)));
    EXPECT_EQ(said.size(), 2u);
}

// Two quick presses must not answer a question that has not been shown yet.
TEST_F(UserCommandsTest, AQuestionIsAnsweredOnlyAfterItWasOpenForHalfASecond) {
    now.tick = 7000;
    user.setQuestion(0);
    EXPECT_THAT(typed("no\n"), IsEmpty());
    now.tick = 7499;
    EXPECT_THAT(pressed(2), IsEmpty()) << "the button selects no tool either";
    EXPECT_THAT(said, ElementsAre(HasSubstr("read the question"), HasSubstr("read the question")));
    now.tick = 7500;
    EXPECT_THAT(typed("no\nno\n"), ElementsAre(Asks(CommandKind::answer, 0)));
    now.tick = 7502;
    EXPECT_THAT(typed("no\n"), IsEmpty()) << "the first answer is still on its way to a tick";
    user.setQuestion(1);
    now.tick = 8001;
    EXPECT_THAT(typed("yes\n"), IsEmpty());
    now.tick = 8501;
    EXPECT_THAT(typed("yes\n"), ElementsAre(Asks(CommandKind::answer, 1)));
}

TEST_F(UserCommandsTest, HelpNamesEveryTool) {
    EXPECT_THAT(typed("help\n"), IsEmpty());
    ASSERT_EQ(said.size(), 1u);
    for (const std::string_view tool : haptics::kToolNames)
        EXPECT_THAT(said[0], HasSubstr("  " + std::string(tool) + " "));
}

TEST_F(UserCommandsTest, NextButtonSelectsTheToolsInOrder) {
    now.tool = Tool::finger;
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::probe)));
    now.tool = Tool::probe;
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::park, 1)));
    EXPECT_THAT(pressed(0), IsEmpty()) << "it was not parked, so it stays in hand";
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::park, 1)));
    now.probe_parked = true;
    EXPECT_THAT(pressed(0), ElementsAre(Asks(CommandKind::tool, Tool::scalpel)));
    EXPECT_THAT(pressed(0), IsEmpty());
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::scalpel)));
    now.tool = Tool::needle;
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::finger)));
    EXPECT_THAT(pressed(1 | 4), IsEmpty()) << "re-arming is the session's, the rest nobody's";
}

// A parked probe keeps its place while the button leads past it. Pressed for a second, it picks it up.
TEST_F(UserCommandsTest, NextPassesOverAParkedProbeUnlessPressedForLong) {
    const auto hold = [&](int ticks) {
        std::vector<haptics::Command> commands = user.update("", 2, now, 2);
        if (!commands.empty() && commands[0].kind == CommandKind::tool) now.tool = Tool(commands[0].value);
        for (int i = 0; i < ticks; ++i, ++now.tick)
            for (const haptics::Command& c : user.update("", 0, now, 2))
                commands.push_back(c);
        user.update("", 0, now, 0);
        return commands;
    };
    now.tool = Tool::finger, now.probe_parked = true;
    EXPECT_THAT(hold(900), ElementsAre(Asks(CommandKind::tool, Tool::scalpel)));
    EXPECT_THAT(hold(900), ElementsAre(Asks(CommandKind::tool, Tool::guide))) << "two presses do not add up";
    EXPECT_THAT(hold(5000),
                ElementsAre(Asks(CommandKind::tool, Tool::needle), Asks(CommandKind::tool, Tool::probe)));
    now.tool = Tool::probe, now.probe_parked = false;
    EXPECT_THAT(user.update("", 2, now, 2), ElementsAre(Asks(CommandKind::park, 1)));
    now.probe_parked = true;
    EXPECT_THAT(user.update("", 0, now, 2), ElementsAre(Asks(CommandKind::tool, Tool::scalpel)));
    now.tool = Tool::scalpel, now.tick += 5000;
    EXPECT_THAT(user.update("", 0, now, 2), IsEmpty())
        << "the press that parks the probe does not pick it up";
}

// In a drainage the needle comes first as the syringe with local anaesthetic.
TEST_F(UserCommandsTest, NextSelectsTheSyringeBeforeTheScalpel) {
    user.setNumbing(true);
    now.probe_parked = true;
    now.tool = Tool::probe;
    for (const Tool tool : {Tool::needle, Tool::scalpel, Tool::guide, Tool::finger, Tool::needle}) {
        EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, tool)));
        now.tool = tool;
    }
    // Whoever leaves it out and punctures through the guide gets on to the wire.
    now.tool = Tool::guide, now.phase = haptics::Phase::pass;
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::needle)));
    now.tool = Tool::needle;
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::wire)));
}

// Through a drain that leaks the wire can be passed again, also when it is in the hand. One that drains is
// left alone, so that the button leads to the other tools.
TEST_F(UserCommandsTest, NextPassesTheWireThroughADrainThatLeaks) {
    now.access.drain = haptics::DrainState::in_place;
    for (const Tool tool : {Tool::wire, Tool::needle}) {
        now.tool = tool;
        now.access.holes_in_duct = 0.5;
        EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::wire)));
        now.access.holes_in_duct = 1.0;
        EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::finger)));
    }
    now.access.drain = haptics::DrainState::misplaced;
    now.tool = Tool::wire;
    EXPECT_THAT(pressed(2), ElementsAre(Asks(CommandKind::tool, Tool::wire)));
}

// The button that re-arms lets go of the tool on the track while it is pressed.
TEST_F(UserCommandsTest, AButtonLetsGoOfTheToolOnTheTrackWhileItIsPressed) {
    UserCommands device{{.rearm = 1, .next = 2, .regrip = 1, .breath = 8}, [](const std::string&) {}};
    EXPECT_THAT(device.update("", 0, now, 1), IsEmpty()) << "nothing is on a track";
    device.update("", 0, now, 0);
    now.tool = Tool::wire;
    now.access.open = true;
    EXPECT_THAT(device.update("", 0, now, 1), ElementsAre(Asks(CommandKind::grip, 0)));
    EXPECT_THAT(device.update("", 0, now, 1), IsEmpty());
    EXPECT_THAT(device.update("", 0, now, 0), ElementsAre(Asks(CommandKind::grip, 1)));
    EXPECT_THAT(typed("let\ngrip\n"), ElementsAre(Asks(CommandKind::grip, 0), Asks(CommandKind::grip, 1)));
    EXPECT_THAT(describeOutcome({CommandKind::grip, 0}, now, now), HasSubstr("wire stays where it is"));
    const UserButtons buttons{.rearm = 1, .regrip = 1};
    EXPECT_THAT(describe(buttons, {}, training::Course::drainage), HasSubstr("button 1 lets go of wire"));
    EXPECT_THAT(describe(buttons), testing::Not(HasSubstr("lets go")));
}

TEST_F(UserCommandsTest, BreathButtonTogglesTheBreathHold) {
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::holdBreath, 0)));
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::breathe, 0)));
    typed("hold\n");
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::breathe, 0)));
}

TEST_F(UserCommandsTest, BreathButtonAsksAgainAfterThePatientGaveUp) {
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::holdBreath, 0)));
    EXPECT_THAT(pressed(0), IsEmpty());
    now.breath_held = true;
    EXPECT_THAT(pressed(0), IsEmpty());
    now.breath_held = false;
    EXPECT_THAT(pressed(8), ElementsAre(Asks(CommandKind::holdBreath, 0)));
}

TEST(Outcome, DescribesTheResultOfACommand) {
    TickOutput before, after;
    const haptics::Command scalpel{CommandKind::tool, std::uint32_t(Tool::scalpel)};
    const haptics::Command park{CommandKind::park, 1}, lift{CommandKind::park, 0};
    before.tool = after.tool = Tool::needle;
    EXPECT_EQ(describeOutcome(scalpel, before, after),
              "the needle stays in hand: it is in the body; withdraw it first");
    after.tool = Tool::scalpel;
    EXPECT_EQ(describeOutcome(scalpel, before, after), "the scalpel is in hand");
    EXPECT_EQ(describeOutcome(scalpel, after, after), "the scalpel is in hand already");
    EXPECT_EQ(describeOutcome(park, before, after), "no probe is in hand");
    EXPECT_EQ(describeOutcome(lift, before, after), "no probe is parked");
    before.tool = after.tool = Tool::probe;
    EXPECT_THAT(describeOutcome(park, before, after), HasSubstr("not parked"));
    after.probe_parked = true;
    EXPECT_EQ(describeOutcome(park, before, after), "the probe stays where it is");
    EXPECT_THAT(describeOutcome(lift, after, after), HasSubstr("its rail guides a needle"));
    EXPECT_EQ(describeOutcome(lift, after, before), "the probe is lifted off");
    EXPECT_THAT(describeOutcome({CommandKind::tool, std::uint32_t(Tool::probe)}, after, after),
                HasSubstr("lift"));
    EXPECT_EQ(describeOutcome({CommandKind::marker, 1}, before, after), "");
    before.stage = haptics::ForceStage::off;
    EXPECT_THAT(describeOutcome({CommandKind::rearm, 0}, before, after), HasSubstr("re-armed"));
    before.stage = haptics::ForceStage::on;
    EXPECT_THAT(describeOutcome({CommandKind::rearm, 0}, before, after), HasSubstr("no fault"));
}

TEST(Outcome, TellsWhyWireDilatorOrDrainCannotBeSelected) {
    const auto asked = [](Tool tool, const TickOutput& now) {
        return describeOutcome({CommandKind::tool, std::uint32_t(tool)}, now, now);
    };
    TickOutput now;
    now.tool = Tool::needle;
    EXPECT_THAT(asked(Tool::wire, now), HasSubstr("needs a needle in the body"));
    EXPECT_THAT(asked(Tool::dilator, now), HasSubstr("the dilator needs a guide wire"));
    now.access.open = now.access.needle_in = now.access.wire_in = true;
    now.tool = Tool::wire;
    EXPECT_THAT(asked(Tool::drain, now), HasSubstr("withdraw it over the wire"));
    EXPECT_THAT(asked(Tool::finger, now), HasSubstr("select it and withdraw it first"));
    now.access.needle_in = false;
    EXPECT_THAT(asked(Tool::needle, now), HasSubstr("the guide wire is in the body"));
    now.tool = Tool::dilator;
    now.access.dilator_m = 0.05;
    EXPECT_THAT(asked(Tool::wire, now), HasSubstr("the dilator is in the body"));
    now.access = {};
    now.access.drain = haptics::DrainState::in_place;
    EXPECT_THAT(asked(Tool::wire, now), HasSubstr("a drain is in place"));
}

// After the needle comes the wire, if there is a needle for it to go through.
TEST_F(UserCommandsTest, NextAfterTheNeedle) {
    now.tool = Tool::needle;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::finger)));
    now.phase = haptics::Phase::pass;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::wire)));
    now.tool = Tool::drain;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::finger)));
    // One button leads through the drainage.
    now.access.open = now.access.needle_in = now.access.wire_in = true;
    now.tool = Tool::wire;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::needle)));
    now.tool = Tool::needle, now.access.needle_in = false;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::dilator)));
    now.tool = Tool::dilator;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::drain)));
    now.tool = Tool::drain;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::wire)));
    now.tool = Tool::finger;
    EXPECT_THAT(typed("next\n"), ElementsAre(Asks(CommandKind::tool, Tool::wire))) << "the way back";
}

// The pedal stays pressed as long as its button is pressed, even if the tool changes in the meantime.
TEST_F(UserCommandsTest, PedalAndInjectionFollowTheirButtons) {
    now.phase = haptics::Phase::pass;
    UserCommands feet{{.rearm = 1, .next = 2, .pedal = 4, .inject = 8}, {}};
    EXPECT_THAT(feet.update("", 0, now, 4), ElementsAre(Asks(CommandKind::pedal, 1)));
    EXPECT_THAT(feet.update("", 0, now, 4 | 1), IsEmpty());
    EXPECT_THAT(feet.update("finger\n", 0, now, 4 | 8), ElementsAre(Asks(CommandKind::tool, Tool::finger)));
    EXPECT_THAT(feet.update("", 0, now, 4 | 8), ElementsAre(Asks(CommandKind::inject, 1000)));
    EXPECT_THAT(feet.update("", 0, now, 0),
                ElementsAre(Asks(CommandKind::pedal, 0), Asks(CommandKind::inject, 0)));
    EXPECT_THAT(user.update("", 0, now, ~0u), IsEmpty()) << "where no button is left for it";
}

TEST_F(UserCommandsTest, InjectionButtonNumbsWhileAsked) {
    now.phase = haptics::Phase::pass;
    UserCommands drainage{{.inject = 8}, {}};
    drainage.setNumbing(true);
    EXPECT_THAT(drainage.update("", 0, now, 8), ElementsAre(Asks(CommandKind::anaesthetic, 1000)));
    EXPECT_THAT(drainage.update("", 0, now, 0), ElementsAre(Asks(CommandKind::anaesthetic, 0)));
    drainage.setNumbing(false);
    EXPECT_THAT(drainage.update("", 0, now, 8), ElementsAre(Asks(CommandKind::inject, 1000)));
}

TEST(Buttons, AreCountedFromOneForAPerson) {
    EXPECT_EQ(describe({.rearm = 1, .next = 2, .breath = 8}),
              "button 1 re-arms, button 2 selects the next tool (pressed for a second: picks up the parked "
              "probe), button 4 starts and ends a breath-hold");
    EXPECT_EQ(describe({.rearm = 0}), "");
    const std::array<std::string_view, 2> names{"the trigger", "menu"};
    EXPECT_EQ(describe({.rearm = 1, .next = 2, .pedal = 4, .inject = 8}, names),
              "the trigger re-arms, menu selects the next tool (pressed for a second: picks up the parked "
              "probe), button 3 is the X-ray pedal, button 4 injects while pressed");
}

}  // namespace
}  // namespace stylet::trainer
