// Driver of a WoodenHaptics or Polhem v1 (open hardware) with its mbed board, over hidapi.
// Facts from forsslund/haptikfabrikenapi (firmware/main.cpp, src/fsusbhapticdevicethread.cpp). Unproven on
// hardware here. The board switches the motors off after 0.5 s without a command.
#pragma once

#include "haptics/devices/driver.h"
#include "haptics/devices/hid_port.h"
#include "haptics/devices/woodenhaptics/woodenhaptics_arm.h"
#include "haptics/devices/woodenhaptics/woodenhaptics_protocol.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics {

// Compares the ids that mbed gives any board of this kind. A match may be a different product.
bool isWoodenBoard(const HidEntry&) noexcept;

DeviceProfile makeProfile(const WoodenModel&) noexcept;  // its name points into the model

class WoodenHaptics final : public Driver {
  public:
    WoodenHaptics(const Clock&, const WoodenModel&);
    WoodenHaptics(const WoodenHaptics&) = delete;
    WoodenHaptics& operator=(const WoodenHaptics&) = delete;

    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    // There is no force until the user has parked the arm and pressed the board's button.
    DeviceStage exchange(const Vec3& force_n, DeviceState&, std::string& why) override;
    void close() noexcept override;

  private:
    enum class ReadResult { report, nothing, lost };
    ReadResult readReport(WoodenReport&, std::string& why);
    WoodenCommand makeCommand(const Vec3& force_n) const noexcept;
    DeviceStage handleMissed(std::string& why);
    DeviceStage processReport(const WoodenReport&, DeviceState&, std::string& why);
    DeviceStage home(const WoodenReport&, std::string& why);
    bool addMotion(const WoodenReport&) noexcept;
    void resetCounts(const WoodenReport&) noexcept;

    Clock clock_;
    WoodenModel model_;
    DeviceProfile profile_;
    HidPort port_;

    // Progress of homing: the button's old press is cleared first, then a new press is awaited.
    enum class Homing { clearButton, awaitButton, calibrate, done };
    Homing homing_ = Homing::clearButton;
    int homing_tries_ = 0;
    std::array<std::int16_t, 6> set_encoders_{};  // encoder values being set on the board
    std::array<std::int16_t, 6> raw_{};           // of the last accepted report
    ArmCounts counts_{};                          // unwrapped
    int missed_ = 0;                              // consecutive exchanges without a plausible report
    std::int64_t command_ns_ = 0;                 // time of the newest command
    std::int64_t stall_ns_ = 0;                   // recent time beyond the usual between two commands
    int reports_since_stall_ = 0;
    bool garbled_ = false;  // the last missed exchange had an implausible report
};

}  // namespace stylet::haptics
