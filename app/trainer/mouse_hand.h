// Mouse and keyboard in place of a haptic device: for whoever has neither that nor a headset. It moves the
// tool in the window and pushes nothing.
#pragma once

#include "app/trainer/window_port.h"
#include "haptics/devices/driver.h"
#include "haptics/loop.h"
#include "haptics/toolbox.h"
#include "patient/planning.h"

namespace stylet::trainer {

inline constexpr const char* kMouse = "mouse";  // as `--device` names it

haptics::DeviceProfile mouseProfile() noexcept;

// Where the tool begins, as a needle would be held there: along the path, before the skin.
patient::Pose mouseStart(const patient::PlannedPath&);

// A point that follows another without a jump: critically damped, no faster than `speed_m_s`.
struct SmoothPoint {
    patient::Vec3 at_m{0.0}, velocity_m_s{0.0};
    void step(const patient::Vec3& wanted_m, double dt_s) noexcept;

    static constexpr double kRate_per_s = 25.0, kSpeed_m_s = 0.10;
};

// Its frame is the patient's. A tool that is pressed with more than kMostPress_n goes no deeper: who feels
// nothing would push it through.
class MouseDriver final : public haptics::Driver {
  public:
    // `start` as mouseStart() has it. The port must outlive it.
    MouseDriver(WindowPort&, const patient::Pose& start, const haptics::GuideSettings&,
                const haptics::Clock&);
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceStage open(std::string& why) override;
    haptics::DeviceStage exchange(const haptics::Vec3& force_n, haptics::DeviceState&,
                                  std::string& why) override;
    void close() noexcept override {}

    static constexpr double kMostPress_n = 10.0;
    static constexpr double kLead_m = 0.12;  // the tool is never further behind the mouse than this

  private:
    void take(const MouseMove&) noexcept;
    void step(double dt_s) noexcept;

    WindowPort& port_;
    patient::Pose start_, wanted_;  // as needles
    haptics::GuideSettings guide_;
    haptics::Clock clock_;
    haptics::DeviceProfile profile_ = mouseProfile();
    SmoothPoint point_;
    patient::Quat turned_;  // where it is turned by now
    patient::Pose held_;    // needle_from_stylus, on its way to that of the tool in hand
    std::int64_t last_ns_ = 0;
};

}  // namespace stylet::trainer
