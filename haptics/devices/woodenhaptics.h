// The driver of a WoodenHaptics or Polhem v1 (open hardware) on its mbed board, over hidapi.
// Facts from forsslund/haptikfabrikenapi (firmware/main.cpp, src/fsusbhapticdevicethread.cpp). Unproven on
// hardware here. Its board cuts the motors when 0.5 s pass without a command.
#pragma once

#include "haptics/devices/driver.h"
#include "haptics/devices/hid_port.h"
#include "haptics/devices/woodenhaptics_arm.h"
#include "haptics/devices/woodenhaptics_protocol.h"

namespace stylet::haptics {

// The numbers that mbed gives any board of its kind: what is found may be another's.
bool isWoodenBoard(const HidEntry&) noexcept;

DeviceProfile profileOf(const WoodenModel&) noexcept;  // its name lives as long as the model

class WoodenHaptics final : public Driver {
  public:
    explicit WoodenHaptics(const WoodenModel&);
    WoodenHaptics(const WoodenHaptics&) = delete;
    WoodenHaptics& operator=(const WoodenHaptics&) = delete;

    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    // The user parks the arm and presses the board's button; until then there is no force.
    DeviceStage exchange(const Vec3& force_n, DeviceState&, std::string& why) override;
    void close() noexcept override;

  private:
    enum class Heard { report, nothing, lost };
    Heard hear(WoodenReport&, std::string& why);
    WoodenCommand commandFor(const Vec3& force_n) const noexcept;
    DeviceStage missed(std::string& why);
    DeviceStage take(const WoodenReport&, DeviceState&, std::string& why);
    DeviceStage home(const WoodenReport&, std::string& why);
    bool follow(const WoodenReport&) noexcept;
    void startAt(const WoodenReport&) noexcept;

    WoodenModel model_;
    DeviceProfile profile_;
    HidPort port_;

    // Why the stage is not ready: the button's old press is cleared first, then a new one is waited for.
    enum class Homing { clearButton, awaitButton, calibrate, done };
    Homing homing_ = Homing::clearButton;
    int homing_tries_ = 0;
    std::array<std::int16_t, 6> set_encoders_{};  // what the board is being told they are
    std::array<std::int16_t, 6> raw_{};           // of the last report that was believed
    ArmCounts counts_{};                          // unwrapped
    int missed_ = 0;                              // exchanges in a row without a report that can be believed
    bool garbled_ = false;                        // the last of them had one that cannot
};

}  // namespace stylet::haptics
