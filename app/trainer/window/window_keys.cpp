#include "app/trainer/window/window_keys.h"

#include <array>

namespace stylet::trainer {

namespace {

struct KeyWord {
    char key;
    const char *name, *what, *word;
};
// The trainee's, with the mouse as the hand.
constexpr std::array kHandKeys{
    KeyWord{'f', "F", "finger", "finger"},         KeyWord{'p', "P", "probe", "probe"},
    KeyWord{'k', "K", "park it", "park"},          KeyWord{'l', "L", "lift it", "lift"},
    KeyWord{'s', "S", "scalpel", "scalpel"},       KeyWord{'g', "G", "guide", "guide"},
    KeyWord{'n', "N", "needle", "needle"},         KeyWord{' ', "Space", "next tool", "next"},
    KeyWord{'h', "H", "hold breath", "hold"},      KeyWord{'b', "B", "breathe", "breathe"},
    KeyWord{kKeyEnter, "Enter", "re-arm", "rearm"}};

}  // namespace

void WindowKeys::press(const KeyPress& press) {
    if (!port_ || !port_->hasHand()) return;
    for (const KeyWord& key : kHandKeys)
        if (press.key == key.key) port_->say(key.word);
    if (press.key == 'x') port_->say((pedal_ = !pedal_) ? "pedal" : "release");
    if (press.key == 'i') port_->say((injects_ = !injects_) ? "inject" : "stop");
}

std::vector<std::vector<WindowKeys::Help>> WindowKeys::rows() const {
    if (!port_ || !port_->hasHand()) return {};
    std::vector<Help> tools;
    for (const KeyWord& key : kHandKeys)
        tools.push_back({key.name, key.what});
    tools.push_back({"X", "X-rays"}), tools.push_back({"I", "inject"});
    return {{{"drag, arrows", "move"},
             {"wheel, Page Down and Up", "in and out"},
             {"with Shift", "turn, finer steps"},
             {"Home", "back to the start"}},
            tools};
}

}  // namespace stylet::trainer
