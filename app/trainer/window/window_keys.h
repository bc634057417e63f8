// Maps the keys of the window to commands for the loops, and provides the key help. Window thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/hands/window_port.h"
#include "app/trainer/window/app_window.h"
#include "app/training/difficulty.h"

namespace stylet::trainer {

class WindowKeys {
  public:
    // With a null port all keys are ignored.
    explicit WindowKeys(std::shared_ptr<WindowPort> port) : port_(std::move(port)) {}

    void press(const KeyPress&);
    // Sets the state that the loops report, whoever has changed it.
    void know(bool paused, bool lights_out, std::optional<training::Difficulty>);
    // True while a comment or a command is typed. All keys then belong to the text.
    bool types() const { return typing_; }
    // True while the view is frozen. The attempt continues.
    bool freezes() const { return frozen_; }

    struct Help {
        std::string key, what;
    };
    // Rows of the key help; empty without a port.
    std::vector<std::vector<Help>> rows() const;
    // Status text: the typed text, paused or frozen. Empty if there is nothing to report.
    std::string state() const;

  private:
    std::shared_ptr<WindowPort> port_;
    void pressTyping(const KeyPress&);
    void pressInstructor(int function_key);
    void pressPlayer(const KeyPress&);

    bool typing_ = false, frozen_ = false, paused_ = false, dark_ = false;
    training::Difficulty difficulty_ = training::Difficulty::practice;
    int older_ = 0;      // number of next pictures that may not show the last key's effect
    bool says_ = false;  // the typed text is a command, not a comment
    std::string text_;
    bool pedal_ = false, injects_ = false;  // as last requested here; pictures show it later
};

}  // namespace stylet::trainer
