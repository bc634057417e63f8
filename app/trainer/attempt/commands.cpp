#include "app/trainer/attempt/commands.h"

#include <array>
#include <bit>
#include <charconv>
#include <utility>

#include "app/training/machines.h"
#include "base/format.h"

namespace stylet::trainer {

using haptics::Command;
using haptics::CommandKind;
using haptics::TickOutput;
using haptics::Tool;
using training::kMlPerM3;

namespace {

// Longer than any command: longer input is invalid.
constexpr std::size_t kLongestCommand = 256;

enum class Act : std::uint8_t { command, next, list };
struct CommandWord {
    std::string_view word, what;
    Act act = Act::command;
    Command command{};
};

constexpr Command toolCommand(Tool tool) {
    return {CommandKind::tool, std::uint32_t(tool)};
}

constexpr std::array kCommandWords{
    CommandWord{"finger", "select the finger, for palpation", Act::command, toolCommand(Tool::finger)},
    CommandWord{"probe", "select the ultrasound probe", Act::command, toolCommand(Tool::probe)},
    CommandWord{"scalpel", "select the scalpel", Act::command, toolCommand(Tool::scalpel)},
    CommandWord{"guide", "select the needle, to snap it into the parked probe's guide", Act::command,
                toolCommand(Tool::guide)},
    CommandWord{"needle", "select the needle", Act::command, toolCommand(Tool::needle)},
    CommandWord{"next", "select the procedure's next tool; a probe in use is parked first", Act::next},
    CommandWord{"park", "park the probe where it is", Act::command, {CommandKind::park, 1}},
    CommandWord{"lift", "lift the parked probe off the skin", Act::command, {CommandKind::park, 0}},
    CommandWord{"hold", "ask the patient for a breath-hold", Act::command, {CommandKind::holdBreath, 0}},
    CommandWord{"breathe", "let the patient breathe again", Act::command, {CommandKind::breathe, 0}},
    CommandWord{"rearm",
                "re-arm the force after a fault; an empty line does the same",
                Act::command,
                {CommandKind::rearm, 0}},
    CommandWord{"stop", "stop the injection of contrast medium", Act::command, {CommandKind::inject, 0}},
    CommandWord{"pedal", "turn X-rays on", Act::command, training::kPedalDown},
    CommandWord{"release", "turn X-rays off", Act::command, training::kPedalUp},
    CommandWord{"help", "list these commands", Act::list},
};

// Commands followed by a number: inject, and every knob of the equipment.
constexpr std::string_view kInject = "inject";
constexpr double kUsual_ml_per_s = 1.0;
constexpr std::array kMachines{training::Machine::xray, training::Machine::ultrasound};

std::string_view trimmed(std::string_view line) {
    constexpr std::string_view kBlank = " \t\r";
    const std::size_t first = line.find_first_not_of(kBlank);
    if (first == std::string_view::npos) return {};
    return line.substr(first, line.find_last_not_of(kBlank) - first + 1);
}

Tool after(Tool tool) {
    return Tool((int(tool) + 1) % haptics::kToolCount);
}

std::string nameOf(Tool tool) {
    return std::string(haptics::kToolNames[std::size_t(tool)]);
}

std::string inShort(double value) {
    return formatted("%g", value);
}

// Parses all of `text` as a number.
std::optional<double> numberIn(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

// Parses "WORD NUMBER". Returns nothing if the word is unknown, or if the number is invalid; then `why_not`
// says why.
std::optional<Command> withNumber(std::string_view line, std::string& why_not) {
    const std::size_t blank = std::min(line.find_first_of(" \t"), line.size());
    const std::string_view word = line.substr(0, blank), rest = trimmed(line.substr(blank));
    const auto within = [&](const std::optional<double>& value, double low, double high) {
        if (value && *value >= low && *value <= high) return true;
        why_not =
            "\"" + std::string(word) + "\" needs a number from " + inShort(low) + " to " + inShort(high);
        return false;
    };
    if (word == kInject) {
        const std::optional<double> ml_per_s = rest.empty() ? kUsual_ml_per_s : numberIn(rest);
        if (!within(ml_per_s, 0.0, training::kMostInjected_m3_per_s * kMlPerM3)) return std::nullopt;
        return training::injectCommand(*ml_per_s / kMlPerM3);
    }
    for (const training::Machine machine : kMachines) {
        const std::span<const training::Knob> knobs = training::knobsOf(machine);
        for (std::size_t i = 0; i < knobs.size(); ++i) {
            if (word != knobs[i].word) continue;
            const std::optional<double> value = numberIn(rest);
            if (!within(value, knobs[i].low, knobs[i].high)) return std::nullopt;
            return training::turn(machine, i, *value);
        }
    }
    return std::nullopt;
}

std::string outcomeOfMachine(const Command& command) {
    if (command.kind == CommandKind::pedal) return command.value != 0 ? "X-rays" : "no more X-rays";
    if (command.kind == CommandKind::inject)
        return command.value == 0 ? "no more contrast medium"
                                  : "contrast medium, " + inShort(double(command.value) / 1000.0) + " ml/s";
    const auto turned = training::turnedBy(command);
    if (!turned) return {};
    return std::string(training::knobsOf(turned->machine)[turned->knob].word) + " " + inShort(turned->value);
}

std::string outcomeOfTool(Tool asked, const TickOutput& before, const TickOutput& now) {
    if (now.tool == asked && before.tool == asked)
        return now.probe_parked && asked == Tool::probe ? "the probe is parked: type \"lift\" to use it again"
                                                        : "the " + nameOf(asked) + " is in hand already";
    if (now.tool == asked) return "the " + nameOf(asked) + " is in hand";
    return "the " + nameOf(now.tool) + " stays in hand: it is in the body; withdraw it first";
}

std::string outcomeOfPark(bool stay, const TickOutput& before, const TickOutput& now) {
    if (stay && now.probe_parked)
        return before.probe_parked ? "the probe is parked already" : "the probe stays where it is";
    if (stay)
        return before.tool == Tool::probe
                   ? "the probe is not parked: lift it off the skin once, then place it again"
                   : "no probe is in hand";
    if (now.probe_parked) return "the probe stays: its rail guides a needle in the body";
    return before.probe_parked ? "the probe is lifted off" : "no probe is parked";
}

}  // namespace

std::string describeWords() {
    std::string text = "Commands with a device (type one and press Enter):\n";
    const auto add = [&](const std::string& word, std::string_view what) {
        text += "  " + word + std::string(13 - word.size(), ' ') + std::string(what) + "\n";
    };
    for (const CommandWord& word : kCommandWords)
        add(std::string(word.word), word.what);
    add(std::string(kInject) + " N", "inject contrast medium through the needle, ml/s (default 1)");
    for (const training::Machine machine : kMachines)
        for (const training::Knob& knob : training::knobsOf(machine))
            add(std::string(knob.word) + " N", knob.what);
    return text;
}

std::string describe(const UserButtons& buttons, std::span<const std::string_view> names) {
    std::string text;
    const auto add = [&](std::uint32_t bit, const char* what) {
        if (bit == 0) return;
        const auto number = std::size_t(std::countr_zero(bit));
        const std::string name =
            number < names.size() ? std::string(names[number]) : "button " + std::to_string(number + 1);
        text += (text.empty() ? "" : ", ") + name + " " + what;
    };
    add(buttons.rearm, "re-arms");
    add(buttons.next, "selects the next tool");
    add(buttons.breath, "starts and ends a breath-hold");
    add(buttons.pedal, "is the X-ray pedal");
    add(buttons.inject, "injects contrast medium while pressed");
    return text;
}

std::vector<Command> UserCommands::take(std::string_view typed, std::uint32_t pressed, const TickOutput& now,
                                        std::uint32_t held) {
    if (!begun_) holds_ = now.breath_held;          // a restart from a bookmark may begin in a breath-hold
    if (held_ && !now.breath_held) holds_ = false;  // the patient gave up the breath-hold
    begun_ = true;
    held_ = now.breath_held;
    waiting_ += typed;
    pressed_ |= pressed;
    std::vector<Command> commands;
    const auto mayGoOn = [&] { return commands.empty() || !changesTool(commands.back()); };
    if (std::exchange(next_wanted_, false) && now.tool == Tool::probe && now.probe_parked)
        commands.push_back(toolCommand(after(now.tool)));
    for (std::size_t end; mayGoOn() && (end = waiting_.find('\n')) != std::string::npos;
         waiting_.erase(0, end + 1))
        takeLine(trimmed(std::string_view(waiting_).substr(0, end)), now, commands);
    if (!hasLine() && waiting_.size() > kLongestCommand) waiting_.resize(kLongestCommand);
    if (!mayGoOn()) return commands;
    if ((pressed_ & buttons_.breath) != 0)
        add({holds_ ? CommandKind::breathe : CommandKind::holdBreath, 0}, commands);
    if ((pressed_ & buttons_.next) != 0) addNext(now, commands);
    pressed_ = 0;
    const std::uint32_t changed = held ^ std::exchange(holding_, held);
    if ((changed & buttons_.pedal) != 0)
        add((held & buttons_.pedal) != 0 ? training::kPedalDown : training::kPedalUp, commands);
    if ((changed & buttons_.inject) != 0)
        add(training::injectCommand((held & buttons_.inject) != 0 ? kUsual_ml_per_s / kMlPerM3 : 0.0),
            commands);
    return commands;
}

void UserCommands::add(const Command& command, std::vector<Command>& commands) {
    if (command.kind == CommandKind::holdBreath || command.kind == CommandKind::breathe)
        holds_ = command.kind == CommandKind::holdBreath;
    commands.push_back(command);
}

// A probe that cannot be parked stays in use, so the next tool waits until the probe is parked.
void UserCommands::addNext(const TickOutput& now, std::vector<Command>& commands) {
    next_wanted_ = now.tool == Tool::probe && !now.probe_parked;
    add(next_wanted_ ? Command{CommandKind::park, 1} : toolCommand(after(now.tool)), commands);
}

void UserCommands::takeLine(std::string_view line, const TickOutput& now, std::vector<Command>& commands) {
    if (line.empty()) line = "rearm";
    for (const CommandWord& word : kCommandWords) {
        if (line != word.word) continue;
        if (word.act == Act::command) add(word.command, commands);
        if (word.act == Act::next) addNext(now, commands);
        if (word.act == Act::list) say_(describeWords());
        return;
    }
    std::string why_not =
        "\"" + std::string(line.substr(0, 40)) + "\" is not a command: type \"help\" for a list";
    if (const std::optional<Command> command = withNumber(line, why_not)) return add(*command, commands);
    say_(why_not);
}

std::string outcomeOf(const Command& command, const TickOutput& before, const TickOutput& now) {
    switch (command.kind) {
        case CommandKind::tool:
            return outcomeOfTool(Tool(command.value), before, now);
        case CommandKind::park:
            return outcomeOfPark(command.value != 0, before, now);
        case CommandKind::holdBreath:
            return "the patient is asked for a breath-hold";
        case CommandKind::breathe:
            return "the patient may breathe";
        case CommandKind::rearm:
            return before.stage == haptics::ForceStage::off ? "re-armed: the force is rising"
                                                            : "nothing to re-arm: there is no fault";
        case CommandKind::inject:
        case CommandKind::pedal:
        case CommandKind::xray:
        case CommandKind::ultrasound:
            return outcomeOfMachine(command);
        case CommandKind::marker:
        case CommandKind::focus:
        case CommandKind::cough:
        case CommandKind::sigh:
        case CommandKind::move:
        case CommandKind::fault:
        case CommandKind::bleed:
        case CommandKind::lights:
        case CommandKind::breathing:
            break;
    }
    return {};
}

}  // namespace stylet::trainer
