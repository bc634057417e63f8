// Mouse and keyboard in place of a haptic device, for users without a device or headset. They move the tool
// in the window. There is no force output.
#pragma once

#include "app/trainer/hands/window_port.h"
#include "app/training/difficulty.h"
#include "haptics/devices/driver.h"
#include "haptics/loop/loop.h"
#include "haptics/loop/toolbox.h"
#include "patient/patient.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

inline constexpr const char* kMouse = "mouse";  // value of `--device`

haptics::DeviceProfile mouseProfile() noexcept;

// Returns the needle pose at which the tool starts, patient frame. StartPlace::path: aligned with the planned
// path, with its tip 30 mm in front of the entry point on the skin. StartPlace::room: in the air above the
// patient's trunk, at a place and with a direction that follow from `seed` and say nothing about the path.
Pose mouseStart(training::StartPlace, const patient::Patient&, const patient::PlannedPath&,
                std::uint64_t seed);

// A point that follows a target without jumps: critically damped, at most kSpeed_m_s.
struct SmoothPoint {
    Vec3 at_m{0.0}, velocity_m_s{0.0};
    void step(const Vec3& wanted_m, double dt_s) noexcept;

    static constexpr double kRate_per_s = 25.0, kSpeed_m_s = 0.10;
};

// Driver for mouse and keyboard. The device frame equals the patient frame. While the tool presses with more
// than kMaxPress_n, it moves no deeper. Without this limit a user, who feels no force, could push the tool
// through the tissue.
class MouseDriver final : public haptics::Driver {
  public:
    // `start`: see mouseStart(). The port must outlive the driver.
    MouseDriver(WindowPort&, const Pose& start, const haptics::GuideSettings&, const haptics::Clock&);
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceStage open(std::string& why) override;
    haptics::DeviceStage exchange(const Vec3& force_n, haptics::DeviceState&, std::string& why) override;
    void close() noexcept override {}

    static constexpr double kMaxPress_n = 10.0;
    // The tool follows a target position that the mouse moves. This is the largest distance between the two.
    static constexpr double kLead_m = 0.12;

  private:
    void apply(const MouseMove&) noexcept;
    void step(double dt_s) noexcept;

    WindowPort& port_;
    Pose start_, wanted_;  // needle poses
    haptics::GuideSettings guide_;
    haptics::Clock clock_;
    haptics::DeviceProfile profile_ = mouseProfile();
    SmoothPoint point_;
    Quat turned_;  // current orientation
    // needle_from_stylus of the tool. After a change of tool it turns gradually to the pose of the new tool.
    Pose tool_pose_;
    std::int64_t last_ns_ = 0;
};

}  // namespace stylet::trainer
