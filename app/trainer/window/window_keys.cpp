#include "app/trainer/window/window_keys.h"

#include <algorithm>
#include <array>
#include <span>

namespace stylet::trainer {

namespace {

struct KeyWord {
    char key;
    const char *name, *what, *word;
};
// Keys for the trainee's commands. An assistant may use them too.
constexpr std::array kToolKeys{
    KeyWord{'f', "F", "finger", "finger"},   KeyWord{'p', "P", "probe", "probe"},
    KeyWord{'k', "K", "park it", "park"},    KeyWord{'l', "L", "lift it", "lift"},
    KeyWord{'s', "S", "scalpel", "scalpel"}, KeyWord{'g', "G", "guide", "guide"},
    KeyWord{'n', "N", "needle", "needle"},   KeyWord{' ', "Space", "next tool", "next"},
    KeyWord{'w', "W", "guide wire", "wire"}, KeyWord{'d', "D", "dilator", "dilator"},
    KeyWord{'a', "A", "drain", "drain"}};
constexpr std::array kActKeys{
    KeyWord{'v', "V", "syringe", "aspirate"}, KeyWord{'h', "H", "hold breath", "hold"},
    KeyWord{'b', "B", "breathe", "breathe"},  KeyWord{'y', "Y", "answer yes", "yes"},
    KeyWord{'u', "U", "answer no", "no"},     KeyWord{kKeyEnter, "Enter", "re-arm", "rearm"}};

// The instructor's function keys.
enum Function : int { kSay = 1, kLights = 7, kComment = 9, kPause = 10, kFreeze = 11, kDifficulty = 12 };
struct FunctionKey {
    int number;
    const char *what, *word;
};
constexpr std::array kFunctionKeys{FunctionKey{kSay, "command", nullptr},
                                   FunctionKey{2, "cough", "cough"},
                                   FunctionKey{3, "sigh", "sigh"},
                                   FunctionKey{4, "bleed", "bleed"},
                                   FunctionKey{5, "movement", "move"},
                                   FunctionKey{6, "device fault", "fault"},
                                   FunctionKey{kLights, "lights", nullptr},
                                   FunctionKey{8, "bookmark", "bookmark"},
                                   FunctionKey{kComment, "comment", nullptr},
                                   FunctionKey{kPause, "pause, resume", nullptr},
                                   FunctionKey{kFreeze, "freeze the view", nullptr},
                                   FunctionKey{kDifficulty, "difficulty", nullptr}};

// Number of setState() calls to ignore after a key press, because they may still report the state before it.
constexpr int kOlder = 5;

// Removes the last UTF-8 character.
void dropLetter(std::string& text) {
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0u) == 0x80u)
        text.pop_back();
    if (!text.empty()) text.pop_back();
}

}  // namespace

void WindowKeys::press(const KeyPress& press) {
    if (!port_) return;
    if (port_->replays()) return pressPlayer(press);
    if (typing_) return pressTyping(press);
    if (press.repeats) return;  // a key sends its command only once
    if (press.key >= kKeyF1 && press.key <= kKeyF12) pressInstructor(1 + press.key - kKeyF1);
    if (!port_->acceptsCommands()) return;
    for (const std::span<const KeyWord> keys : {std::span<const KeyWord>(kToolKeys), {kActKeys}})
        for (const KeyWord& key : keys)
            if (press.key == key.key && isOffered(key.key)) port_->pushLine(key.word);
    if (press.key == 'o') port_->pushLine("expert");
    if (press.key == 't' && port_->hasToolInput()) port_->pushLine("skin");
    if (press.key == 'x') port_->pushLine((pedal_ = !pedal_) ? "pedal" : "release");
    if (press.key == 'i') port_->pushLine("inject or stop");
    if (press.key == 'm' && isOffered('m')) port_->pushLine("numb or stop");
}

// There is nothing to re-arm without a haptic device, and nothing to numb or to answer in a puncture.
bool WindowKeys::isOffered(char key) const {
    if (key == 'm') return training::hasAnaesthesia(course_);
    if (key == 'y' || key == 'u')
        return training::contains(training::stepsOf(course_), training::Step::reviewCase);
    return key != kKeyEnter || port_->offersRearm();
}

void WindowKeys::setState(bool paused, bool lights_out, std::optional<training::Difficulty> difficulty) {
    if (older_ > 0) {
        --older_;
        return;
    }
    paused_ = paused, dark_ = lights_out;
    difficulty_ = difficulty.value_or(difficulty_);
}

void WindowKeys::pressPlayer(const KeyPress& press) {
    const bool finer = press.shift;
    if (press.key == ' ' && !press.repeats) port_->pushLine("toggle");
    if (press.key == kKeyLeft) port_->pushLine(finer ? "skip -0.1" : "skip -1");
    if (press.key == kKeyRight) port_->pushLine(finer ? "skip 0.1" : "skip 1");
    if (press.key == kKeyHome) port_->pushLine("seek 0");
    if (press.key == kKeyEnd) port_->pushLine("seek 1");
    if (press.key == kKeyPageUp) port_->pushLine("speed 2");
    if (press.key == kKeyPageDown) port_->pushLine("speed 0.5");
}

void WindowKeys::pressTyping(const KeyPress& press) {
    if (text_.size() + press.text.size() < WindowPort::kMaxLineLength - 16) text_ += press.text;
    if (press.key == kKeyBackspace) dropLetter(text_);
    if (press.key == kKeyEnter && !text_.empty())
        port_->pushLine(typing_command_ ? text_ : "comment " + text_);
    if (press.key == kKeyEnter || press.key == kKeyEscape) typing_ = false;
}

void WindowKeys::pressInstructor(int function_key) {
    for (const FunctionKey& key : kFunctionKeys)
        if (key.number == function_key && key.word) port_->pushLine(key.word);
    if (function_key == kLights) {
        port_->pushLine((dark_ = !dark_) ? "lights out" : "lights on");
        older_ = kOlder;
    }
    if (function_key == kPause) {
        port_->pushLine("pause or go on");
        paused_ = !paused_;
        older_ = kOlder;
    }
    if (function_key == kDifficulty) {
        difficulty_ = training::Difficulty((int(difficulty_) + 1) % int(training::kDifficultyNames.size()));
        port_->pushLine("difficulty " + std::string(training::kDifficultyNames[std::size_t(difficulty_)]));
        older_ = kOlder;
    }
    if (function_key == kFreeze) frozen_ = !frozen_;
    if (function_key == kComment || function_key == kSay) {
        typing_ = true, typing_command_ = function_key == kSay;
        text_.clear();
    }
}

std::string WindowKeys::state() const {
    if (typing_)
        return (typing_command_ ? "command: " : "comment: ") + text_ +
               (typing_command_ ? "\u2502  (Enter sends, Escape cancels)"
                                : "\u2502  (Enter stores, Escape cancels)");
    if (paused_) return "PAUSED \u2013 F10 resumes";
    if (frozen_) return "FROZEN VIEW \u2013 F11 returns to live";
    return {};
}

WindowKeys::HelpRows WindowKeys::rows(const training::DifficultyRules& rules) const {
    if (!port_) return {};
    if (port_->replays())
        return {{{"Space", "play, pause"},
                 {"arrows", "one second back, forward"},
                 {"with Shift", "0.1 s"},
                 {"Home, End", ""},
                 {"Page Up and Down", "faster, slower"},
                 {"the bar", "anywhere"}}};
    std::vector<Help> instructor{{"Instructor", ""}};
    for (const FunctionKey& key : kFunctionKeys)
        instructor.push_back({"F" + std::to_string(key.number), key.what});
    if (!port_->acceptsCommands()) return {instructor};
    std::vector<Help> tools, acts;
    for (const KeyWord& key : kToolKeys)
        tools.push_back({key.name, key.what});
    for (const KeyWord& key : kActKeys)
        if (isOffered(key.key)) acts.push_back({key.name, key.what});
    acts.push_back({"X", "X-rays"}), acts.push_back({"I", "inject"});
    if (isOffered('m')) acts.push_back({"M", "numb"});
    if (rules.expert) acts.push_back({"O", "watch the expert"});
    HelpRows rows;
    if (port_->hasToolInput()) {
        rows.push_back({{"drag, arrows", "move"},
                        {"wheel forward (away from you), Page Down", "in"},
                        {"wheel back, Page Up", "out"},
                        {"with Shift", "turn, finer steps"},
                        {"Q, E", "roll it"}});
        if (rules.snap) rows.back().push_back({"T", "to the skin"});
        if (rules.home) rows.back().push_back({"Home", "back to the start"});
    }
    rows.push_back(tools);
    rows.push_back(acts);
    // In the trainee's window the trainee's keys come first.
    rows.insert(port_->hasToolInput() ? rows.end() : rows.begin(), instructor);
    return rows;
}

WindowKeys::HelpRows splitRows(const WindowKeys::HelpRows& rows, double width_px,
                               const std::function<double(const WindowKeys::Help&)>& entry_px) {
    WindowKeys::HelpRows split;
    for (const std::vector<WindowKeys::Help>& row : rows) {
        split.emplace_back();
        double used_px = 0.0;
        for (const WindowKeys::Help& help : row) {
            const double needed_px = entry_px(help);
            if (!split.back().empty() && used_px + needed_px > width_px) split.emplace_back(), used_px = 0.0;
            split.back().push_back(help);
            used_px += needed_px;
        }
    }
    return split;
}

WindowKeys::HelpRows fitRows(const WindowKeys::HelpRows& rows, double width_px, int max_rows, int page,
                             const std::function<double(const WindowKeys::Help&)>& entry_px) {
    WindowKeys::HelpRows split = splitRows(rows, width_px, entry_px);
    if (int(split.size()) <= max_rows) return split;
    WindowKeys::HelpRows joined(1);
    for (const std::vector<WindowKeys::Help>& row : rows)
        joined[0].insert(joined[0].end(), row.begin(), row.end());
    split = splitRows(joined, width_px, entry_px);
    if (int(split.size()) <= max_rows) return split;
    const WindowKeys::Help more{"J", "more keys"};
    split = splitRows(joined, width_px - entry_px(more), entry_px);
    const int count = int(split.size()), pages = (count + max_rows - 1) / max_rows;
    const auto first = split.begin() + std::min(page % pages * max_rows, count - max_rows);
    WindowKeys::HelpRows shown(first, first + max_rows);
    shown.back().push_back(more);
    return shown;
}

}  // namespace stylet::trainer
