// Translates the keys of the window into command lines for the trainer's loops (window_port.h), and provides
// the key help. All calls are from the window thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/hands/window_port.h"
#include "app/trainer/window/app_window.h"
#include "app/training/difficulty.h"
#include "app/training/progress.h"

namespace stylet::trainer {

class WindowKeys {
  public:
    // With a null port all keys are ignored.
    explicit WindowKeys(std::shared_ptr<WindowPort> port) : port_(std::move(port)) {}

    void press(const KeyPress&);
    // Sets the state that the loops report. Inputs other than this window may have changed it.
    void setState(bool paused, bool lights_out, std::optional<training::Difficulty>);
    // Of the attempt; without this call, kDefaultCourse.
    void setCourse(training::Course course) { course_ = course; }
    // True while the user types a comment or a command. All keys then belong to that text.
    bool isTyping() const { return typing_; }
    // True while the view is frozen. The attempt continues.
    bool isFrozen() const { return frozen_; }

    struct Help {
        std::string key, what;
        friend bool operator==(const Help&, const Help&) = default;
    };
    using HelpRows = std::vector<std::vector<Help>>;
    // Rows of the key help, with the keys that difficulty and course allow; empty without a port.
    HelpRows rows(const training::DifficultyRules&) const;
    // Status text: the typed text, or that the attempt is paused or the view frozen. Empty if there is
    // nothing to report.
    std::string state() const;

  private:
    std::shared_ptr<WindowPort> port_;
    bool isOffered(char key) const;
    void pressTyping(const KeyPress&);
    void pressInstructor(int function_key);
    void pressPlayer(const KeyPress&);

    bool typing_ = false, frozen_ = false, paused_ = false, dark_ = false;
    training::Difficulty difficulty_ = training::Difficulty::practice;
    training::Course course_ = training::kDefaultCourse;
    // This many of the next pictures may have been drawn before the last key press took effect, so their
    // state is ignored.
    int older_ = 0;
    bool typing_command_ = false;  // the typed text is a command, not a comment
    std::string text_;
    // What this window requested last. Pictures show it only some time later.
    bool pedal_ = false;
};

// Splits rows that are wider than `width_px` between two entries. `entry_px`: width of an entry with the gap
// after it.
WindowKeys::HelpRows splitRows(const WindowKeys::HelpRows&, double width_px,
                               const std::function<double(const WindowKeys::Help&)>& entry_px);
// The same, but at most `max_rows` rows. If there are more, the entries of all rows are written one after the
// other. If that is still too much, returns only page number `page` (from 0; behind the last comes the
// first). All pages have `max_rows` rows, and the last row of each ends with the key for the next page.
WindowKeys::HelpRows fitRows(const WindowKeys::HelpRows&, double width_px, int max_rows, int page,
                             const std::function<double(const WindowKeys::Help&)>& entry_px);
inline constexpr char kMoreKeys = 'j';

}  // namespace stylet::trainer
