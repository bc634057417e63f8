// SpaceMouse driver over hidapi, input only. The deflection of the cap sets the needle's speed. Facts as in
// spacemouse_report.h. The sign of the rotation axes is unproven on hardware.
#pragma once

#include "haptics/devices/driver.h"
#include "haptics/devices/hid_port.h"
#include "haptics/devices/spacemouse/rate_control.h"
#include "haptics/devices/spacemouse/spacemouse_report.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics {

bool isSpaceMouseEntry(const HidEntry&);  // true for a SpaceMouse
DeviceProfile spaceMouseProfile(const RateSettings& = {}) noexcept;

class SpaceMouse final : public Driver {
  public:
    // The clock measures how long the cap was held in one position; device's thread.
    explicit SpaceMouse(const Clock&, const RateSettings& = {});

    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    DeviceStage exchange(const Vec3& force_n, DeviceState&, std::string& why) override;
    void close() noexcept override { port_.close(); }

  private:
    bool readPending(std::string& why);

    Clock clock_;
    RateSettings rate_;
    DeviceProfile profile_;
    HidPort port_;
    SpaceMouseInput input_;
    // Starts at the end toward the user, outside the patient. Keeps its value while the device is away.
    Pose device_from_stylus_;
    std::int64_t last_ns_ = 0, last_report_ns_ = 0;
    int malformed_ = 0;  // consecutive
};

}  // namespace stylet::haptics
