// What somebody at a window says and does, on its way to the loops: words as on the terminal, and the motions
// of a tool that is moved with mouse and keys.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "haptics/rings.h"
#include "haptics/tool.h"
#include "patient/geometry.h"

namespace stylet::trainer {

// One turn of the mouse or press of a key, patient frame.
struct MouseMove {
    patient::Vec3 moved_m{0.0};
    patient::Vec3 turned_rad{0.0};  // about the tip
    double deeper_m = 0.0;          // along the tool
    double rolled_rad = 0.0;        // about its own line, counter-clockwise as the hand sees it
    bool home = false;              // back to where it began, before the rest
};

// Where a replay is.
struct Playback {
    double at_s = 0.0, length_s = 0.0, speed = 1.0;
    bool plays = false;
};

// Window thread on one side, hand's and session's threads on the other; nobody ever waits. Shared: a window
// whose display is stuck outlives the attempt.
class WindowPort {
  public:
    static constexpr std::size_t kLongestLine = 200;  // bytes; the rest of a longer one is cut off

    // Before the threads begin: a user holds the tool, and his words have keys here.
    void giveWords() { takes_words_ = true; }
    bool takesWords() const { return takes_words_; }
    // Likewise: and the mouse is the hand that holds it.
    void giveHand() { has_hand_ = takes_words_ = true; }
    bool hasHand() const { return has_hand_; }
    // Likewise: there is no attempt, but the record of one (player.h).
    void giveReplay() { replays_ = true; }
    bool replays() const { return replays_; }

    // Window thread. False where nobody has taken the ones before.
    bool say(std::string_view line) noexcept;
    bool move(const MouseMove& move) noexcept { return moves_.push(move); }
    Playback playback() noexcept;

    // Session thread. Whole lines, each with its end.
    std::string typed();
    // Session thread. What is in hand, and how hard it is pressed, as of the newest tick.
    void tell(haptics::Tool tool, double force_n) noexcept;

    // The player's thread.
    void tell(const Playback& playback) noexcept { playback_.publish(playback); }

    // Hand's thread.
    bool take(MouseMove& move) noexcept { return moves_.pop(move); }
    haptics::Tool inHand() const noexcept { return tool_.load(std::memory_order_relaxed); }
    double pressing_n() const noexcept { return pressing_n_.load(std::memory_order_relaxed); }

  private:
    struct Line {
        std::uint8_t length = 0;
        std::array<char, kLongestLine> text{};
    };
    haptics::Ring<Line> lines_{64};
    haptics::Ring<MouseMove> moves_{1024};
    std::atomic<haptics::Tool> tool_{haptics::Tool::needle};
    std::atomic<double> pressing_n_{0.0};
    haptics::Snapshot<Playback> playback_;
    bool takes_words_ = false, has_hand_ = false, replays_ = false;
};

}  // namespace stylet::trainer
