// What the keys of the window say to the loops, and the lines that tell which key does what. Window thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/window/app_window.h"
#include "app/trainer/window_port.h"
#include "app/training/difficulty.h"

namespace stylet::trainer {

class WindowKeys {
  public:
    // Null: nobody listens, and no key does anything.
    explicit WindowKeys(std::shared_ptr<WindowPort> port) : port_(std::move(port)) {}

    void press(const KeyPress&);
    // As the loops have it, whoever has asked for it.
    void know(bool paused, bool lights_out, std::optional<training::Difficulty>);
    // While a comment or a word is typed all that comes is its text.
    bool types() const { return typing_; }
    // The pictures stand, the attempt goes on.
    bool freezes() const { return frozen_; }

    struct Help {
        std::string key, what;
    };
    // A row each; none where nobody listens.
    std::vector<std::vector<Help>> rows() const;
    // What is typed, paused or frozen; empty where there is nothing to say.
    std::string state() const;

  private:
    std::shared_ptr<WindowPort> port_;
    void pressTyping(const KeyPress&);
    void pressInstructor(int function_key);
    void pressPlayer(const KeyPress&);

    bool typing_ = false, frozen_ = false, paused_ = false, dark_ = false;
    training::Difficulty difficulty_ = training::Difficulty::practice;
    int older_ = 0;      // pictures that know nothing of the last key
    bool says_ = false;  // what is typed is a word for the loops, no comment
    std::string text_;
    bool pedal_ = false, injects_ = false;  // as last asked for here: what is seen comes later
};

}  // namespace stylet::trainer
