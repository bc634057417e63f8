// The driver of a SpaceMouse, over hidapi: input only. How far the cap is pushed is how fast the needle
// moves. Facts as in spacemouse_report.h. The sense of its turning axes is unproven on hardware here.
#pragma once

#include "haptics/devices/driver.h"
#include "haptics/devices/hid_port.h"
#include "haptics/devices/rate_control.h"
#include "haptics/devices/spacemouse_report.h"
#include "haptics/loop.h"

namespace stylet::haptics {

bool isCap(const HidEntry&);  // a SpaceMouse
DeviceProfile spaceMouseProfile(const RateSettings& = {}) noexcept;

class SpaceMouse final : public Driver {
  public:
    // The clock tells how long the cap was held where it was; device's thread.
    explicit SpaceMouse(const Clock&, const RateSettings& = {});

    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    DeviceStage exchange(const Vec3& force_n, DeviceState&, std::string& why) override;
    void close() noexcept override { port_.close(); }

  private:
    bool takeWaiting(std::string& why);

    Clock clock_;
    RateSettings rate_;
    DeviceProfile profile_;
    HidPort port_;
    SpaceMouseInput input_;
    // Begins at the end toward the user, outside the patient; stays where it was while the device is away.
    patient::Pose device_from_stylus_;
    std::int64_t last_ns_ = 0, heard_ns_ = 0;
    int malformed_ = 0;  // in a row
};

}  // namespace stylet::haptics
