// Snap to skin: places the tool in use on the skin beneath it, for a trainee with a mouse or a controller.
// The device moves the tool there at the speed of a hand, so the motion is recorded and replayed like any
// other.
#pragma once

#include <optional>
#include <string>

#include "app/training/difficulty.h"
#include "haptics/loop/simulation.h"
#include "haptics/tools/touch.h"

namespace stylet::trainer {

class ControllerPort;
class WindowPort;

// Pose of the tool in use on the skin that it points at, or on the skin below it; patient frame, at the
// tick's breath. Finger, probe and scalpel stand upright on the skin. A needle keeps its direction, which is
// for the trainee to choose. Scalpel and needle stop in front of the skin. Returns nothing if the difficulty
// forbids it, if the tool is in the body, or if there is no skin; `why_not` is then the reason.
std::optional<Pose> poseOnSkin(const training::DifficultyRules&, const haptics::TickOutput&,
                               const patient::Patient&, const haptics::TouchMap&, std::string& why_not);

// Session thread. Has the device move the tool to this pose, in the driver's frame. The device is the
// controller, or the mouse if `controller` is null. Returns why it cannot; empty if it can.
std::string requestSnap(const Pose& driver_from_tool, ControllerPort* controller, WindowPort& mouse);

// True while a tool touches the patient or lies in the body.
bool touchesPatient(const haptics::TickOutput&) noexcept;

// Offset between the hand and the tool of a device that follows the hand. It changes smoothly.
class SnapOffset {
  public:
    // Moves the tool from the hand's pose to `goal`.
    void aim(const Pose& hand, const Pose& goal) noexcept;
    // Moves the tool back to the hand.
    void release() noexcept;
    void step(double dt_s) noexcept;
    Pose apply(const Pose& hand) const noexcept;

    static constexpr double kSpeed_m_s = 0.10, kTurn_rad_s = 1.5;

  private:
    Vec3 shift_m_{0.0}, wanted_m_{0.0};
    Quat turn_{1.0, 0.0, 0.0, 0.0}, wanted_turn_{1.0, 0.0, 0.0, 0.0};
};

}  // namespace stylet::trainer
