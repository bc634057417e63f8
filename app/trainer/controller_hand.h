// A headset's controller in place of a haptic device: it moves the tool and vibrates, and pushes nothing. So
// the trainer can be used with a headset alone.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>

#include "haptics/devices/driver.h"
#include "haptics/loop.h"

namespace stylet::trainer {

inline constexpr const char* kControllers = "controllers";  // as `--device` names them

enum class ControllerSide : int { left, right };  // the hand that has the tool

struct Vibration {
    float amplitude = 0.0f;  // [0, 1]
    std::int64_t duration_ns = 0;
};

// Between the frame thread, which has the session, and the hand's thread. The session may be lost and come
// back: meanwhile there is no hand.
class ControllerPort {
  public:
    // Where the grip is in the runtime's space at a time of CLOCK_MONOTONIC; nothing while it is not tracked.
    using GripAt = std::function<std::optional<patient::Pose>(std::int64_t when_ns)>;

    // Frame thread. Who is asked from now on. Null before the session goes: when it returns nobody asks it.
    void attach(GripAt);
    // Frame thread, each frame: the room that is drawn, where the controller points, what is pressed.
    struct Frame {
        patient::Pose room_from_stage;
        std::optional<patient::Pose> grip_from_aim;  // absent: as it was
        std::uint32_t buttons = 0;
        std::array<float, 2> thumbstick{0.0f, 0.0f};  // right, up in [-1, 1]
    };
    void see(const Frame&);
    // Frame thread: the last of them.
    Frame seen();
    std::optional<Vibration> takeVibration();

    // Hand's thread: the tool, its tip at the origin and +z toward the hand, in the room that is drawn.
    std::optional<patient::Pose> toolAt(std::int64_t when_ns, std::uint32_t& buttons);
    // Session thread. The newest wins.
    void vibrate(const Vibration&);

  private:
    std::mutex asked_;  // while the runtime is asked, which may take its time
    GripAt grip_at_;
    std::mutex mutex_;
    patient::Pose room_from_stage_, grip_from_aim_;
    std::uint32_t buttons_ = 0;
    std::array<float, 2> thumbstick_{0.0f, 0.0f};
    std::optional<Vibration> vibration_;
};

// What is pressed of a controller, as buttons: those of the tool's hand, then the other's (live_hand.h has
// what they mean).
struct ControllerKeys {
    bool select = false, menu = false;
    float squeeze = 0.0f;
};
std::uint32_t controllerButtons(const ControllerKeys& tool, const ControllerKeys& other = {});
inline constexpr std::array<std::string_view, 5> kControllerButtons{
    "the trigger", "menu (B)", "squeezing", "the other hand's trigger", "squeezing the other hand"};

haptics::DeviceProfile controllerProfile() noexcept;

// Its frame is the room that is drawn. Not tracked for kLostAfter_ns it is absent, and back as soon as it is.
class ControllerDriver final : public haptics::Driver {
  public:
    ControllerDriver(ControllerPort&, ControllerSide, const haptics::Clock&);
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceStage open(std::string& why) override;
    haptics::DeviceStage exchange(const haptics::Vec3& force_n, haptics::DeviceState&,
                                  std::string& why) override;
    void close() noexcept override {}

    static constexpr std::int64_t kLostAfter_ns = 100'000'000;

  private:
    std::int64_t now() const { return clock_.now_ns(clock_.context); }
    ControllerPort& port_;
    std::string missing_;
    haptics::Clock clock_;
    haptics::DeviceProfile profile_ = controllerProfile();
    std::int64_t tracked_ns_ = 0;
};

// What of the ticks is felt in the controller: the touch of the skin, every cut. Session thread.
class Vibrations {
  public:
    std::optional<Vibration> take(const haptics::TickOutput& newest);

  private:
    std::optional<haptics::TickOutput> last_;
};

}  // namespace stylet::trainer
