// A headset's controller as input device. It moves the tool and vibrates, but renders no force. With it, the
// trainer needs only a headset.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>

#include "app/trainer/hands/snap.h"
#include "haptics/devices/driver.h"
#include "haptics/loop/loop.h"

namespace stylet::trainer {

inline constexpr const char* kControllers = "controllers";  // the name for `--device`

enum class ControllerSide : int { left, right };  // the hand that holds the controller with the tool
// `hand`: "left" or "right".
inline ControllerSide controllerSide(std::string_view hand) {
    return hand == "left" ? ControllerSide::left : ControllerSide::right;
}

struct Vibration {
    float amplitude = 0.0f;  // [0, 1]
    std::int64_t duration_ns = 0;
};

// Connects the frame thread, which owns the OpenXR session, with the device's thread. The session may be lost
// and opened again. In between, no controller is tracked.
class ControllerPort {
  public:
    // Grip pose in the runtime's space at a CLOCK_MONOTONIC time; nullopt while not tracked.
    using GripAt = std::function<std::optional<Pose>(std::int64_t when_ns)>;

    // Frame thread. Sets the function that toolAt() calls. Pass null before the OpenXR session is
    // destroyed: once attach() returns, no call is running or will follow.
    void attach(GripAt);
    // Frame thread, once per frame: the pose of the drawn room, the controller's aim, and the pressed
    // buttons.
    struct Frame {
        Pose room_from_stage;
        std::optional<Pose> grip_from_aim;  // absent: unchanged
        std::uint32_t buttons = 0;
        std::array<float, 2> thumbstick{0.0f, 0.0f};  // right, up in [-1, 1]
    };
    void publish(const Frame&);
    // Frame thread. The frame last passed to publish().
    Frame frame();
    std::optional<Vibration> popVibration();

    // Device's thread. Tool pose in the drawn room: tip at the origin, +z toward the hand. nullopt while
    // not tracked.
    std::optional<Pose> toolAt(std::int64_t when_ns, std::uint32_t& buttons);
    // Device's thread. A pose that the session has asked for and that has not been popped.
    std::optional<Pose> popSnap();
    bool touches() const { return touches_.load(); }
    // Session thread. A newer vibration replaces one that is still pending.
    void vibrate(const Vibration&);
    // Session thread. Has the device move the tool to this pose in the drawn room (snap.h).
    void snapTo(const Pose& room_from_tool);
    // Session thread. Whether the tool touches the patient.
    void setTouching(bool touches) { touches_.store(touches); }

  private:
    std::mutex grip_mutex_;  // held during calls into the runtime, which may be slow
    GripAt grip_at_;
    std::mutex mutex_;
    Frame frame_;  // `grip_from_aim` is the newest one that was present
    std::optional<Vibration> vibration_;
    std::optional<Pose> snap_;
    std::atomic<bool> touches_{false};
};

// The pressed inputs of one controller. controllerButtons() maps them to button bits: first those of the
// tool's hand, then those of the other hand (meanings: live_hand.h).
struct ControllerKeys {
    bool select = false, menu = false;
    float squeeze = 0.0f;
    float stick_up = 0.0f;  // of the thumbstick, in [-1, 1]
};
std::uint32_t controllerButtons(const ControllerKeys& tool, const ControllerKeys& other = {});
inline constexpr std::array<std::string_view, 7> kControllerButtons{"the trigger",
                                                                    "menu (B)",
                                                                    "squeezing",
                                                                    "the other hand's trigger",
                                                                    "squeezing the other hand",
                                                                    "the other hand's menu",
                                                                    "the stick, pushed up,"};

// The trigger of the tool's hand: while it is held, the tool stays where snap to skin has put it.
inline constexpr std::uint32_t kSnapButton = 1u << 0;

haptics::DeviceProfile controllerProfile() noexcept;

// The device frame is the drawn room. A snapped tool follows the hand's motion at an offset until the trigger
// is released and the tool touches nothing; then it moves back to the hand. After kLostAfter_ns without
// tracking the device reports absent. It is ready again as soon as the controller is tracked. Time in which
// the device's thread did not run does not count: the computer was late then, and the controller may have
// been tracked all along.
class ControllerDriver final : public haptics::Driver {
  public:
    ControllerDriver(ControllerPort&, ControllerSide, const haptics::Clock&);
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceStage open(std::string& why) override;
    haptics::DeviceStage exchange(const Vec3& force_n, haptics::DeviceState&, std::string& why) override;
    void close() noexcept override {}

    static constexpr std::int64_t kLostAfter_ns = 100'000'000;
    static constexpr std::int64_t kMaxStep_ns = 20'000'000;  // what one exchange counts at most

  private:
    std::int64_t now() const { return clock_.now_ns(clock_.context); }
    ControllerPort& port_;
    std::string missing_;
    haptics::Clock clock_;
    haptics::DeviceProfile profile_ = controllerProfile();
    std::int64_t last_ns_ = 0, untracked_ns_ = 0;  // last exchange; time without tracking that counts
    SnapOffset snap_;
};

// Selects the ticks at which the controller vibrates: first touch of the skin, and every cut. Session thread.
class Vibrations {
  public:
    std::optional<Vibration> update(const haptics::TickOutput& newest);

  private:
    std::optional<haptics::TickOutput> last_;
};

}  // namespace stylet::trainer
