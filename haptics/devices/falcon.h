// The Novint Falcon: three motors and three encoders behind an FTDI chip. No orientation: that comes from
// elsewhere (clutch.h). See README.md for firmware, homing and calibration.
//
// Facts from libnifalcon (BSD), file by file in the headers of its parts: falcon_kinematics.h,
// falcon_packet.h, falcon_firmware.h, ftdi_bus.h. What the device does when the host stops sending is not
// known, so zero is sent on every way out.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "haptics/devices/driver.h"
#include "haptics/devices/falcon_calibration.h"
#include "haptics/devices/falcon_firmware.h"
#include "haptics/devices/falcon_kinematics.h"
#include "haptics/devices/falcon_packet.h"
#include "haptics/devices/ftdi_bus.h"
#include "haptics/loop.h"

namespace stylet::haptics::falcon {

struct Settings {
    Firmware firmware{};        // for a device that has none
    Calibration calibration{};  // else uncalibrated, and the profile says so
};

DeviceProfile profileOf(const Calibration&) noexcept;

// What the motors are told for a force at a grip position: 10,000 counts a N m of thigh torque (libnifalcon,
// undocumented) over the calibration, at most the profile's peak and 4095 counts, shortened as a whole so
// that the direction stays. Zero where there is no such pose.
std::array<std::int16_t, 3> motorsFor(const Vec3& force_n, const Vec3& grip_m, const Calibration&) noexcept;

// Without a good reply for so long, the force is zero: whatever it was for, nobody knows where the grip is.
inline constexpr std::int64_t kReplyDeadline_ns = 6'000'000;
// And for so long, the connection is given up.
inline constexpr std::int64_t kGiveUp_ns = 200'000'000;

// DeviceState: the grip's position, no rotation; buttons as in falcon_packet.h.
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
    // What is wrong with what it sends, for the user.
    enum class Trouble : std::uint8_t { none, silent, garbled, jumped, impossible };

    DeviceStage probe(std::string& why);
    DeviceStage load(std::string& why);
    DeviceStage run(const Vec3& force_n, DeviceState&, std::string& why);
    BusResult talk(const Command&, std::int64_t until_ns, std::optional<Reply>&, std::string& why);
    bool take(const Reply&, std::int64_t now_ns, DeviceState&) noexcept;
    bool follows(const Counts&, double elapsed_ms) noexcept;
    void note(Trouble) noexcept;
    DeviceStage lose(std::string& why);
    DeviceStage giveUp(std::string& why) const;
    std::int64_t now() const noexcept { return clock_.now_ns(clock_.context); }

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
    bool jumping_ = false;       // the last reply was too far from the last good one
    bool behind_ = false;        // a reply may still be under way
    std::int64_t heard_ns_ = 0;  // the last good reply
    double silence_ms_ = 1.0;    // before the last reply that was no jump
    Counts counts_{};
    Vec3 rates_{0.0};  // counts a ms
    Vec3 grip_m_ = kCentre_m;
};

}  // namespace stylet::haptics::falcon
