// The Novint Falcon: three motors and three encoders behind an FTDI chip. It senses no orientation; clutch.h
// supplies one. See haptics/devices/README.md for firmware, homing and calibration.
//
// The facts are from libnifalcon (BSD) and are listed in the headers of the parts: falcon_kinematics.h,
// falcon_packet.h, falcon_firmware.h, ftdi_bus.h. It is not known what the device does when the host stops
// sending, so zero is sent on every exit.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "haptics/devices/driver.h"
#include "haptics/devices/falcon/falcon_calibration.h"
#include "haptics/devices/falcon/falcon_firmware.h"
#include "haptics/devices/falcon/falcon_kinematics.h"
#include "haptics/devices/falcon/falcon_packet.h"
#include "haptics/devices/falcon/ftdi_bus.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics::falcon {

struct Settings {
    Firmware firmware{};        // used if the device has no firmware loaded
    Calibration calibration{};  // default: uncalibrated, and marked so in the profile
};

DeviceProfile makeProfile(const Calibration&) noexcept;

// Motor commands for a force at a grip position: 10,000 counts per N m of torque at the thigh (the
// driven link of a leg; number from libnifalcon, undocumented). The force is first divided by the
// calibration. The counts are limited to the profile's peak force and to 4095 counts by scaling all three, so
// that the direction is kept. Zero if the pose is unreachable.
std::array<std::int16_t, 3> computeMotorCounts(const Vec3& force_n, const Vec3& grip_m,
                                               const Calibration&) noexcept;

// Without a valid reply for this long the force is zero, because the grip's position is unknown.
inline constexpr std::int64_t kReplyDeadline_ns = 6'000'000;
// Without a valid reply for this long the connection is given up.
inline constexpr std::int64_t kGiveUp_ns = 200'000'000;

// DeviceState has the grip's position without rotation, and the buttons of falcon_packet.h.
class FalconDriver final : public Driver {
  public:
    // The clock is used on the device's thread.
    FalconDriver(std::unique_ptr<FtdiBus>, const Clock&, Settings);
    ~FalconDriver() override;
    FalconDriver(const FalconDriver&) = delete;
    FalconDriver& operator=(const FalconDriver&) = delete;

    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    DeviceStage exchange(const Vec3& force_n, DeviceState&, std::string& why) override;
    void close() noexcept override;

  private:
    enum class Step : std::uint8_t { probe, load, run };
    // What is wrong with the device's replies, for the error message.
    enum class Trouble : std::uint8_t { none, silent, garbled, jumped, impossible };

    DeviceStage probe(std::string& why);
    DeviceStage load(std::string& why);
    DeviceStage run(const Vec3& force_n, DeviceState&, std::string& why);
    BusResult sendAndReceive(const Command&, std::int64_t until_ns, std::optional<Reply>&, std::string& why);
    bool processReply(const Reply&, std::int64_t now_ns, DeviceState&) noexcept;
    bool isPlausibleMotion(const Counts&, double elapsed_ms) noexcept;
    void recordTrouble(Trouble) noexcept;
    DeviceStage reportLost(std::string& why);
    DeviceStage giveUp(std::string& why) const;
    std::int64_t now() const noexcept { return clock_.now(); }

    std::unique_ptr<FtdiBus> bus_;
    Clock clock_;
    Settings settings_;
    DeviceProfile profile_;
    FirmwareLoader loader_;
    PacketReader reader_;

    bool open_ = false;
    Step step_ = Step::probe;
    int probes_ = 0, loads_ = 0;
    bool homed_ = false;
    int homed_replies_ = 0;
    Trouble trouble_ = Trouble::none;
    bool jumping_ = false;            // the last reply was too far from the last valid one
    bool reply_pending_ = false;      // a reply may still be in transit
    std::int64_t last_reply_ns_ = 0;  // time of the last valid reply
    double silence_ms_ = 1.0;         // silence before the current reply; not updated while jumping_
    Counts counts_{};
    Vec3 rates_{0.0};  // counts per ms
    Vec3 grip_m_ = kCentre_m;
};

}  // namespace stylet::haptics::falcon
