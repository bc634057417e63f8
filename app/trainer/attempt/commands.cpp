#include "app/trainer/attempt/commands.h"

#include <fmt/core.h>
#include <array>
#include <bit>
#include <utility>

#include "app/trainer/stores/console.h"
#include "app/training/attempt_fold.h"
#include "app/training/equipment.h"

namespace stylet::trainer {

using haptics::Command;
using haptics::CommandKind;
using haptics::TickOutput;
using haptics::Tool;
using training::kMlPerM3;

namespace {

// Longer input is invalid. No command is this long.
constexpr std::size_t kMaxCommandLength = 256;

enum class Act : std::uint8_t { command, next, snap, expert, list };
struct CommandWord {
    std::string_view word, what;
    Act act = Act::command;
    Command command{};
};

constexpr Command toolCommand(Tool tool) {
    return {CommandKind::tool, std::uint32_t(tool)};
}

constexpr std::string_view kRearm = "rearm";
constexpr const char* kStop = "stop";
constexpr std::array kCommandWords{
    CommandWord{"finger", "select the finger, for palpation", Act::command, toolCommand(Tool::finger)},
    CommandWord{"probe", "select the ultrasound probe", Act::command, toolCommand(Tool::probe)},
    CommandWord{"scalpel", "select the scalpel", Act::command, toolCommand(Tool::scalpel)},
    CommandWord{"guide", "select the needle, to snap it into the parked probe's guide", Act::command,
                toolCommand(Tool::guide)},
    CommandWord{"needle", "select the needle", Act::command, toolCommand(Tool::needle)},
    CommandWord{"wire", "select the guide wire, through the needle or the drain in the body", Act::command,
                toolCommand(Tool::wire)},
    CommandWord{"dilator", "select the dilator, over the guide wire", Act::command,
                toolCommand(Tool::dilator)},
    CommandWord{"drain", "select the drain, over the guide wire", Act::command, toolCommand(Tool::drain)},
    CommandWord{"let",
                "let go of the needle, wire, dilator or drain on the track, to move the hand back",
                Act::command,
                {CommandKind::grip, 0}},
    CommandWord{"grip", "grip it again", Act::command, {CommandKind::grip, 1}},
    CommandWord{"next", "select the procedure's next tool; a probe in use is parked first", Act::next},
    CommandWord{"park", "park the probe where it is", Act::command, {CommandKind::park, 1}},
    CommandWord{"lift", "lift the parked probe off the skin", Act::command, {CommandKind::park, 0}},
    CommandWord{"hold", "ask the patient for a breath-hold", Act::command, {CommandKind::holdBreath, 0}},
    CommandWord{"breathe", "let the patient breathe again", Act::command, {CommandKind::breathe, 0}},
    CommandWord{kRearm,
                "re-arm the force of a haptic device after a fault; an empty line does the same",
                Act::command,
                {CommandKind::rearm, 0}},
    CommandWord{"yes", "drainage: answer the question about the case", Act::command, training::kYes},
    CommandWord{"no", "the same", Act::command, training::kNo},
    CommandWord{"aspirate", "draw with a syringe at the needle", Act::command, training::kAspirate},
    CommandWord{"skin", "mouse: place the tool on the skin beneath it; controllers: hold the trigger",
                Act::snap},
    CommandWord{"expert", "guided attempts: show how the expert does this step, or no longer", Act::expert},
    CommandWord{kStop, "stop every injection", Act::command, {CommandKind::inject, 0}},
    CommandWord{"pedal", "turn X-rays on", Act::command, training::kPedalDown},
    CommandWord{"release", "turn X-rays off", Act::command, training::kPedalUp},
    CommandWord{"help", "list these commands", Act::list},
};

// Commands followed by a number: "inject", "numb" and every knob of the equipment.
constexpr std::string_view kInject = "inject", kNumb = "numb";
// Of the window's keys. Either stops the syringe that flows. A key cannot know: what it started may have been
// refused.
constexpr std::string_view kInjectOrStop = "inject or stop", kNumbOrStop = "numb or stop";
constexpr double kUsual_ml_per_s = 1.0;
constexpr std::array kMachines{training::Machine::xray, training::Machine::ultrasound};

// A drain with a smaller share of its side holes in ducts is taken to leak. Only the step's evidence judges
// it exactly.
constexpr double kDrains = 0.8;

// The tool in hand lies on the track of an open access.
bool onTrack(const TickOutput& now) {
    return now.access.open && (haptics::isAccessTool(now.tool) || haptics::isNeedleTool(now.tool));
}

// The procedure's next tool. After the needle comes the wire if the needle is in the body, else the finger.
// With a wire in the body: the needle is drawn out over it, dilator and drain follow, then the wire is drawn
// out. Through a drain that leaks it can be passed again. `numbing`: local anaesthesia is not finished, so
// the needle comes before the scalpel. A parked probe stays where it is.
Tool nextTool(const TickOutput& now, bool numbing) {
    if (now.access.open) {
        if (now.tool == Tool::wire && now.access.drain_m > 0.0) return Tool::drain;
        if (now.tool == Tool::wire) return now.access.needle_in ? Tool::needle : Tool::dilator;
        if (haptics::isNeedleTool(now.tool)) return now.access.needle_in ? Tool::wire : Tool::dilator;
        if (now.tool == Tool::dilator) return Tool::drain;
        return Tool::wire;
    }
    const bool outside = now.phase == haptics::Phase::outside;
    const bool leaks =
        now.access.drain == haptics::DrainState::misplaced ||
        (now.access.drain == haptics::DrainState::in_place && now.access.holes_in_duct < kDrains);
    if (outside && leaks && (now.tool == Tool::wire || now.tool == Tool::needle)) return Tool::wire;
    if (haptics::isAccessTool(now.tool)) return Tool::finger;
    if (now.tool == Tool::finger && now.probe_parked) return numbing ? Tool::needle : Tool::scalpel;
    if (now.tool == Tool::probe && numbing) return Tool::needle;
    if (now.tool == Tool::guide && numbing && outside) return Tool::finger;
    if (now.tool == Tool::needle && outside) return numbing ? Tool::scalpel : Tool::finger;
    return Tool((int(now.tool) + 1) % haptics::kToolCount);
}

std::string_view nameOf(Tool tool) {
    return enumName(haptics::kToolNames, tool);
}

// Parses "WORD NUMBER". Returns nothing if the word is unknown, the number is invalid, or the course has no
// such command. `why_not` is then set to the reason, except for an unknown word.
std::optional<Command> withNumber(std::string_view line, training::Course course, std::string& why_not) {
    const std::size_t blank = std::min(line.find_first_of(" \t"), line.size());
    const std::string_view word = line.substr(0, blank), rest = trimmed(line.substr(blank));
    const auto within = [&](const std::optional<double>& value, double low, double high) {
        if (value && *value >= low && *value <= high) return true;
        why_not = fmt::format("\"{}\" needs a number from {:g} to {:g}", word, low, high);
        return false;
    };
    if (word == kNumb && !training::hasAnaesthesia(course)) {
        why_not = "local anaesthesia is part of a drainage, and this attempt is a puncture";
        return std::nullopt;
    }
    if (word == kInject || word == kNumb) {
        const bool contrast = word == kInject;
        const double most =
            contrast ? training::kMaxInjectionRate_m3_per_s : training::kMaxAnaestheticRate_m3_per_s;
        const std::optional<double> ml_per_s = rest.empty() ? kUsual_ml_per_s : parseNumber<double>(rest);
        if (!within(ml_per_s, 0.0, most * kMlPerM3)) return std::nullopt;
        return contrast ? training::injectCommand(*ml_per_s / kMlPerM3)
                        : training::anaesthetiseCommand(*ml_per_s / kMlPerM3);
    }
    for (const training::Machine machine : kMachines) {
        const std::span<const training::Knob> knobs = training::machineKnobs(machine);
        for (std::size_t i = 0; i < knobs.size(); ++i) {
            if (word != knobs[i].word) continue;
            const std::optional<double> value = parseNumber<double>(rest);
            if (!within(value, knobs[i].low, knobs[i].high)) return std::nullopt;
            return training::knobCommand(machine, i, *value);
        }
    }
    return std::nullopt;
}

// Returns an empty string for commands that do not concern the equipment.
std::string describeEquipmentOutcome(const Command& command) {
    if (command.kind == CommandKind::pedal) return command.value != 0 ? "X-rays" : "no more X-rays";
    if (command.kind == CommandKind::inject || command.kind == CommandKind::anaesthetic) {
        const char* what = command.kind == CommandKind::inject ? "contrast medium" : "local anaesthetic";
        return command.value == 0 ? fmt::format("no more {}", what)
                                  : fmt::format("{}, {:g} ml/s", what, double(command.value) / 1000.0);
    }
    const auto turned = training::decodeKnobCommand(command);
    if (!turned) return {};
    return fmt::format("{} {:g}", training::machineKnobs(turned->machine)[turned->knob].word, turned->value);
}

// Reason why the access does not allow `asked`, or an empty string.
std::string whyNot(Tool asked, const TickOutput& now) {
    const haptics::AccessOutput& access = now.access;
    if (access.open && access.dilator_m > 0.0) return "the dilator is in the body; withdraw it over the wire";
    if (access.open && access.needle_in && asked != Tool::wire)
        return haptics::isAccessTool(asked) ? "the needle is still in the body; withdraw it over the wire"
                                            : "the needle is in the body; select it and withdraw it first";
    if (asked == Tool::wire)
        return access.drain == haptics::DrainState::in_place
                   ? "a drain is in place; withdraw the needle to pass the wire through the drain"
                   : "the wire needs a needle in the body: puncture a duct first";
    if (asked == Tool::drain &&
        (access.drain == haptics::DrainState::in_place || access.drain == haptics::DrainState::misplaced))
        return "the drain is free of the wire; push the wire into its loop before you move it";
    if (asked == Tool::dilator && access.wire_in) return "the drain is in the body";
    if (haptics::isAccessTool(asked))
        return fmt::format("the {} needs a guide wire in the body to slide over", nameOf(asked));
    if (access.open && haptics::isNeedleTool(asked))
        return "the guide wire is in the body: the needle is not needed; withdraw the wire first";
    return {};
}

std::string describeToolOutcome(Tool asked, const TickOutput& before, const TickOutput& now) {
    if (asked == Tool::wire && now.tool == asked && now.access.drain_m > 0.0 && !before.access.open &&
        now.access.open)
        return "the wire is in the drain: push it into the drain's loop";
    if (now.tool == asked && before.tool == asked)
        return now.probe_parked && asked == Tool::probe
                   ? "the probe is parked: type \"lift\" to use it again"
                   : fmt::format("the {} is in hand already", nameOf(asked));
    if (now.tool == asked) return fmt::format("the {} is in hand", nameOf(asked));
    if (const std::string why = whyNot(asked, now); !why.empty())
        return fmt::format("the {} stays in hand: {}", nameOf(now.tool), why);
    return fmt::format("the {} stays in hand: it is in the body; withdraw it first", nameOf(now.tool));
}

// Reason why a syringe cannot do this, or an empty string. Like the wire, the syringe needs a needle in the
// body. Contrast medium also flows through a drain in place (training::AttemptFold), and local anaesthetic
// into skin that the needle only dents.
std::string whyNoSyringe(const Command& command, const TickOutput& now) {
    const bool draws = command.kind == CommandKind::aspirate;
    const bool contrast = command.kind == CommandKind::inject && command.value != 0;
    const bool numbs = command.kind == CommandKind::anaesthetic && command.value != 0;
    if (!draws && !contrast && !numbs) return {};
    const bool touches = now.phase != haptics::Phase::outside;
    const bool dents_skin = now.phase == haptics::Phase::tenting && now.tissue == haptics::Tissue::air &&
                            now.depth_m <= training::kGasDepth_m;  // deeper, it is in lung or gas
    if (touches && (numbs || !dents_skin)) return {};
    if (draws) return "nothing is drawn: the syringe needs a needle in the body";
    if (numbs) return "nothing is injected: local anaesthetic needs a needle in the body";
    if (now.access.drain == haptics::DrainState::in_place) return {};
    return "nothing is injected: contrast medium needs a needle in the body, or a drain in place";
}

std::string describeParkOutcome(bool stay, const TickOutput& before, const TickOutput& now) {
    if (stay && now.probe_parked)
        return before.probe_parked ? "the probe is parked already" : "the probe stays where it is";
    if (stay)
        return before.tool == Tool::probe
                   ? (before.tool_awaits_exit
                          ? "the probe is not parked: lift it off the skin once, then place it again"
                          : "the probe is not parked: press it flat on the skin first")
                   : "no probe is in hand";
    if (now.probe_parked) return "the probe stays: its rail guides a needle in the body";
    return before.probe_parked ? "the probe is lifted off" : "no probe is parked";
}

std::string describeGripOutcome(bool grip, const TickOutput& now) {
    if (!onTrack(now)) return "no tool on a track is in hand";
    const std::string_view tool = nameOf(now.tool);
    return grip ? fmt::format("the {} is gripped again", tool)
                : fmt::format("the {} stays where it is: move the hand back", tool);
}

}  // namespace

std::string describeCommands(bool exerts_force, training::Course course) {
    std::string text = "Commands with a device (type one and press Enter):\n";
    for (const CommandWord& word : kCommandWords)
        if (exerts_force || word.command.kind != CommandKind::rearm || word.act != Act::command)
            text += helpLine(word.word, word.what);
    text += helpLine("inject N", "inject contrast medium through the needle, ml/s (default 1)");
    if (training::hasAnaesthesia(course))
        text += helpLine("numb N", "drainage: inject local anaesthetic through the needle, ml/s (default 1)");
    for (const training::Machine machine : kMachines)
        for (const training::Knob& knob : training::machineKnobs(machine))
            text += helpLine(fmt::format("{} N", knob.word), knob.what);
    return text;
}

std::string describe(const UserButtons& buttons, std::span<const std::string_view> names,
                     training::Course course) {
    std::string text;
    const auto add = [&](std::uint32_t bit, std::string_view what) {
        if (bit == 0) return;
        const auto number = std::size_t(std::countr_zero(bit));
        text += text.empty() ? "" : ", ";
        text += number < names.size() ? fmt::format("{} {}", names[number], what)
                                      : fmt::format("button {} {}", number + 1, what);
    };
    add(buttons.rearm, "re-arms");
    const bool lets_go = buttons.regrip != 0 && course == training::Course::drainage;
    if (lets_go) add(buttons.regrip, "lets go of wire, dilator or drain while pressed");
    const bool asks = training::contains(training::stepsOf(course), training::Step::reviewCase);
    add(buttons.next, fmt::format("selects the next tool (pressed for a second: picks up the parked probe{})",
                                  asks ? "; answers no" : ""));
    add(buttons.breath,
        asks ? "starts and ends a breath-hold (answers yes)" : "starts and ends a breath-hold");
    add(buttons.pedal, "is the X-ray pedal");
    add(buttons.inject,
        training::hasAnaesthesia(course)
            ? "injects while pressed (local anaesthetic until the incision or the puncture, then contrast "
              "medium)"
            : "injects while pressed");
    add(buttons.aspirate, "draws with the syringe");
    add(buttons.snap, "places the tool on the skin while pressed");
    add(buttons.expert, "shows the expert, or no longer");
    return text;
}

std::vector<Command> UserCommands::update(std::string_view typed, std::uint32_t pressed,
                                          const TickOutput& now, std::uint32_t buttons_down) {
    if (!begun_) hold_requested_ = now.breath_held;  // a restart from a bookmark may begin in a breath-hold
    if (breath_held_ && !now.breath_held) hold_requested_ = false;  // the patient had to breathe
    begun_ = true;
    if (std::exchange(asked_, question_) != question_) asked_at_ = now.tick;
    breath_held_ = now.breath_held;
    waiting_ += typed;
    pressed_ |= pressed;
    std::vector<Command> commands;
    const auto mayGoOn = [&] { return commands.empty() || !changesTool(commands.back()); };
    if (std::exchange(next_wanted_, false) && now.tool == Tool::probe && now.probe_parked)
        commands.push_back(toolCommand(nextTool(now, numbing_)));
    if (mayGoOn() && liftsProbe(now, buttons_down)) commands.push_back(toolCommand(Tool::probe));
    for (std::optional<std::string> line; mayGoOn() && (line = popLine(waiting_));)
        parseLine(*line, now, commands);
    if (!hasLine() && waiting_.size() > kMaxCommandLength) waiting_.resize(kMaxCommandLength);
    if (!mayGoOn()) return commands;
    if (question_) answerByButton(now, commands);
    if ((pressed_ & buttons_.breath) != 0)
        add({hold_requested_ ? CommandKind::breathe : CommandKind::holdBreath, 0}, now, commands);
    if ((pressed_ & buttons_.snap) != 0) snap_ = true;
    if ((pressed_ & buttons_.expert) != 0) expert_ = true;
    if ((pressed_ & buttons_.aspirate) != 0) add(training::kAspirate, now, commands);
    if ((pressed_ & buttons_.next) != 0) {
        addNext(now, commands);
        if (now.probe_parked) lift_at_ = now.tick + std::uint64_t(kLiftAfter_s / dt_s_ + 0.5);
    }
    pressed_ = 0;
    const std::uint32_t changed = buttons_down ^ std::exchange(last_buttons_down_, buttons_down);
    if ((changed & buttons_.regrip) != 0 && onTrack(now))
        add({CommandKind::grip, (buttons_down & buttons_.regrip) != 0 ? 0u : 1u}, now, commands);
    if ((changed & buttons_.pedal) != 0)
        add((buttons_down & buttons_.pedal) != 0 ? training::kPedalDown : training::kPedalUp, now, commands);
    if ((changed & buttons_.inject) != 0) addInjection((buttons_down & buttons_.inject) != 0, now, commands);
    return commands;
}

// Releasing the button stops only what it has started.
void UserCommands::addInjection(bool down, const TickOutput& now, std::vector<Command>& commands) {
    const double m3_per_s = down ? kUsual_ml_per_s / kMlPerM3 : 0.0;
    const std::size_t before = commands.size();
    if (down || injects_)
        add(numbing_ ? training::anaesthetiseCommand(m3_per_s) : training::injectCommand(m3_per_s), now,
            commands);
    injects_ = down && commands.size() > before;
}

// With both buttons at once nothing is answered.
void UserCommands::answerByButton(const TickOutput& now, std::vector<Command>& commands) {
    const bool yes = (pressed_ & buttons_.breath) != 0, no = (pressed_ & buttons_.next) != 0;
    if (yes != no) addAnswer(yes ? training::kYes : training::kNo, now, commands);
    pressed_ &= ~(buttons_.breath | buttons_.next);
}

// The next question is open once the ticks have executed this answer, so a second answer must wait too.
void UserCommands::addAnswer(const Command& answer, const TickOutput& now, std::vector<Command>& commands) {
    if (!question_) return say_("no question is open");
    if (double(now.tick - asked_at_) * dt_s_ < kReadQuestion_s)
        return say_("not answered: read the question, then answer");
    asked_at_ = now.tick;
    add(answer, now, commands);
}

void UserCommands::add(const Command& command, const TickOutput& now, std::vector<Command>& commands) {
    if (const std::string why = whyNoSyringe(command, now); !why.empty()) return say_(why);
    if (command.kind == CommandKind::inject || command.kind == CommandKind::anaesthetic)
        flows_ = command.value != 0;
    if (command.kind == CommandKind::holdBreath || command.kind == CommandKind::breathe)
        hold_requested_ = command.kind == CommandKind::holdBreath;
    commands.push_back(command);
}

// True once, when `next` has been pressed long enough since it was pressed with the probe parked.
bool UserCommands::liftsProbe(const TickOutput& now, std::uint32_t buttons_down) {
    if ((buttons_down & buttons_.next) == 0 || !now.probe_parked) lift_at_.reset();
    if (!lift_at_ || now.tick < *lift_at_) return false;
    lift_at_.reset();
    return true;
}

// A probe that cannot be parked stays in use, so the next tool waits until the probe is parked.
void UserCommands::addNext(const TickOutput& now, std::vector<Command>& commands) {
    next_wanted_ = now.tool == Tool::probe && !now.probe_parked;
    add(next_wanted_ ? Command{CommandKind::park, 1} : toolCommand(nextTool(now, numbing_)), now, commands);
}

void UserCommands::parseLine(std::string_view line, const TickOutput& now, std::vector<Command>& commands) {
    if (line.empty()) line = kRearm;
    if (line == kInjectOrStop) line = flows_ ? kStop : kInject;
    if (line == kNumbOrStop) line = flows_ ? kStop : kNumb;
    if (!exerts_force_ && line == kRearm) return;  // an empty line, or a habit from a haptic device
    for (const CommandWord& word : kCommandWords) {
        if (line != word.word) continue;
        if (word.act == Act::command && word.command.kind == CommandKind::answer)
            return addAnswer(word.command, now, commands);
        if (word.act == Act::command) add(word.command, now, commands);
        if (word.act == Act::next) addNext(now, commands);
        if (word.act == Act::snap) snap_ = true;
        if (word.act == Act::expert) expert_ = true;
        if (word.act == Act::list) say_(describeCommands(exerts_force_, course_));
        return;
    }
    std::string why_not =
        fmt::format("\"{}\" is not a command: type \"help\" for a list", line.substr(0, 40));
    if (const std::optional<Command> command = withNumber(line, course_, why_not))
        return add(*command, now, commands);
    say_(why_not);
}

std::string describeOutcome(const Command& command, const TickOutput& before, const TickOutput& now) {
    if (command.kind == CommandKind::tool) return describeToolOutcome(Tool(command.value), before, now);
    if (command.kind == CommandKind::grip) return describeGripOutcome(command.value != 0, now);
    if (command.kind == CommandKind::park) return describeParkOutcome(command.value != 0, before, now);
    if (command.kind == CommandKind::holdBreath) return "the patient is asked for a breath-hold";
    if (command.kind == CommandKind::breathe) return "the patient may breathe";
    if (command.kind == CommandKind::rearm)
        return before.stage == haptics::ForceStage::off ? "re-armed: the force is rising"
                                                        : "nothing to re-arm: there is no fault";
    if (command.kind == CommandKind::aspirate)
        return fmt::format("the syringe draws {}", enumName(training::kDrawnNames, training::drawnAt(now)));
    if (command.kind == CommandKind::answer) return command.value != 0 ? "answered: yes" : "answered: no";
    return describeEquipmentOutcome(command);
}

}  // namespace stylet::trainer
