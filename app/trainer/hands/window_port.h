// Passes input from the window to the loops: commands, as typed on the terminal, and motions of a tool that
// the user moves with mouse and keys.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/geometry.h"
#include "base/rings.h"
#include "haptics/tools/tool.h"

namespace stylet::trainer {

// Tool motion from one mouse event or key press, in the patient frame.
struct MouseMove {
    Vec3 moved_m{0.0};
    Vec3 turned_rad{0.0};     // about the tip
    double deeper_m = 0.0;    // along the tool
    double rolled_rad = 0.0;  // about its own axis, counter-clockwise as seen from the hand
    bool home = false;        // first return to the start pose, then apply the rest
};

// Playback state of a replay.
struct Playback {
    double at_s = 0.0, length_s = 0.0, speed = 1.0;
    bool plays = false;
};

// Connects the window thread with the device thread and the session thread. No thread ever waits here.
// Ownership is shared, because a window whose display hangs may outlive the attempt.
class WindowPort {
  public:
    static constexpr std::size_t kMaxLineLength = 200;  // bytes; longer lines are truncated

    // Call before the threads start. Enables the keys for the user's commands: a user controls the tool.
    void enableCommands() { takes_words_ = true; }
    bool acceptsCommands() const { return takes_words_; }
    // Call before the threads start. Enables the key that re-arms the force: the user has a haptic device.
    void enableRearm() { rearms_ = true; }
    bool offersRearm() const { return rearms_; }
    // Same, and lets the mouse move the tool.
    void enableToolInput() { has_hand_ = takes_words_ = true; }
    bool hasToolInput() const { return has_hand_; }
    // Call before the threads start. The window then shows a replay instead of an attempt (player.h).
    void enableReplay() { replays_ = true; }
    bool replays() const { return replays_; }

    // Window thread. Returns false if the ring is full.
    bool pushLine(std::string_view line) noexcept;
    bool move(const MouseMove& move) noexcept { return moves_.push(move); }
    Playback playback() noexcept;

    // Session thread. Returns the pending lines, each ending in a newline.
    std::string typed();
    // Session thread. Sets the tool in use and its contact force, as of the newest tick.
    void publish(haptics::Tool tool, double force_n) noexcept;

    // Session thread. Has the device move the tool to this pose (snap.h), in the driver's frame. Returns
    // false if the ring is full.
    [[nodiscard]] bool snapTo(const Pose& device_from_tool) noexcept { return snaps_.push(device_from_tool); }

    // Player's thread.
    void publish(const Playback& playback) noexcept { playback_.publish(playback); }

    // Device thread.
    bool popMove(MouseMove& move) noexcept { return moves_.pop(move); }
    bool popSnap(Pose& device_from_tool) noexcept { return snaps_.pop(device_from_tool); }
    haptics::Tool inHand() const noexcept { return tool_.load(std::memory_order_relaxed); }
    double pressing_n() const noexcept { return pressing_n_.load(std::memory_order_relaxed); }

  private:
    struct Line {
        std::uint8_t length = 0;
        std::array<char, kMaxLineLength> text{};
    };
    Ring<Line> lines_{64};
    Ring<MouseMove> moves_{1024};
    Ring<Pose> snaps_{8};
    std::atomic<haptics::Tool> tool_{haptics::Tool::needle};
    std::atomic<double> pressing_n_{0.0};
    Snapshot<Playback> playback_;
    bool takes_words_ = false, rearms_ = false, has_hand_ = false, replays_ = false;
};

}  // namespace stylet::trainer
