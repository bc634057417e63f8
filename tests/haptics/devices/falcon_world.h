// A Falcon emulator, its driver and a haptic loop on one thread in virtual time. Time advances whenever the
// bus waits, and the loop ticks at every millisecond.
#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "haptics/devices/falcon/falcon.h"
#include "haptics/devices/polled.h"
#include "haptics/output/safety.h"
#include "tests/support/constants.h"
#include "tests/support/falcon_emulator.h"

namespace stylet::test {

struct FalconWorld;

// Connects the driver to the emulator, with the wait times of a real bus.
class EmulatedBus final : public haptics::FtdiBus {
  public:
    explicit EmulatedBus(FalconWorld& world) : world_(&world) {}
    haptics::DeviceStage open(std::string& why) override;
    haptics::BusResult control(std::uint8_t request, std::uint16_t value, std::string& why) override;
    haptics::BusResult write(std::span<const std::uint8_t>, int wait_ms, std::string& why) override;
    haptics::BusResult read(haptics::BusBytes&, int wait_ms, std::string& why) override;
    void close() noexcept override;

  private:
    FalconWorld* world_;
};

struct FalconWorld {
    explicit FalconWorld(bool has_firmware = true, haptics::falcon::Settings settings = {})
        : falcon(has_firmware),
          device(std::make_unique<haptics::falcon::FalconDriver>(std::make_unique<EmulatedBus>(*this),
                                                                 clock(), std::move(settings)),
                 clock()) {}

    haptics::Clock clock() {
        return {this,
                [](void* w) noexcept {
                    const auto& world = *static_cast<FalconWorld*>(w);
                    return world.now_ns + world.clock_error_ns;
                },
                [](void* w, std::int64_t t) noexcept {
                    auto& world = *static_cast<FalconWorld*>(w);
                    world.pass(t - world.now_ns - world.clock_error_ns);
                }};
    }

    // One tick of the haptic loop and its output stage. `force_n` stands for the model's force.
    void tick() {
        const haptics::DeviceState state = device.read(now_ns);
        if (state.fresh != 0) grip_m = state.device_from_stylus.position_m;
        ready = (state.flags & haptics::kDeviceReady) != 0;
        buttons = state.buttons;
        const std::uint32_t fault_bits = haptics::checkDevice(safety, device.profile(), state, 1e-3);
        haptics::stepSafety(safety, fault_bits, glm::length(force_n), 0.0, 1e-3);
        if (!loop_stalled) device.send(safety.level * force_n);
    }
    void pass(std::int64_t span_ns) {
        for (const std::int64_t end_ns = now_ns + span_ns; now_ns < end_ns;) {
            now_ns = std::min(end_ns, (now_ns / kMs + 1) * kMs);
            if (falcon.hasMotorForce()) pushed_ns = now_ns;
            if (now_ns % kMs == 0) tick();
        }
    }
    void runFor(std::int64_t span_ns) {
        for (const std::int64_t end_ns = now_ns + span_ns; now_ns < end_ns;) {
            const std::int64_t due_ns = device.poll() - clock_error_ns;
            pass(std::clamp(due_ns - now_ns, std::int64_t(0), end_ns - now_ns));
        }
    }
    // Brings the device up: homed, armed and rendering force.
    void bringUp() {
        runFor(50 * kMs);
        falcon.home();
        runFor(50 * kMs);
        arm();
        runFor(50 * kMs);
    }
    // Re-arms as the user would, and skips the wait and the force ramp of 1.5 s.
    void arm() {
        haptics::rearm(safety);
        if (safety.stage != haptics::ForceStage::waiting) return;
        safety.stage = haptics::ForceStage::on;
        safety.level = 1.0;
    }
    bool armed() const {
        return safety.stage == haptics::ForceStage::rising || safety.stage == haptics::ForceStage::on;
    }
    // Names of all active faults.
    std::string fault() const {
        std::string names;
        for (const haptics::FaultText& text : haptics::faultTexts())
            if ((safety.faults & text.bit) != 0) names += std::string(names.empty() ? "" : ", ") + text.name;
        return names;
    }
    std::string why() const { return device.report().why; }

    FalconEmulator falcon;
    bool plugged = true;
    std::int64_t now_ns = 1'000 * kMs, pushed_ns = 0;
    std::int64_t clock_error_ns = 0;  // error of the driver's clock
    // State of the loop.
    Vec3 force_n{0.0, 0.0, -2.0}, grip_m{0.0};
    haptics::SafetyState safety;
    bool ready = false, loop_stalled = false;
    std::uint32_t buttons = 0;
    haptics::PolledDevice device;  // last, because it must be destroyed first
};

inline haptics::DeviceStage EmulatedBus::open(std::string& why) {
    world_->pass(kMs);
    if (world_->plugged && !world_->falcon.faults.unplugged) return haptics::DeviceStage::opening;
    why = "none is plugged in";
    return haptics::DeviceStage::absent;
}

inline haptics::BusResult EmulatedBus::control(std::uint8_t request, std::uint16_t value, std::string& why) {
    world_->pass(kMs / 8);
    if (world_->falcon.faults.unplugged) {
        why = "it was unplugged";
        return haptics::BusResult::lost;
    }
    world_->falcon.control(request, value);
    return haptics::BusResult::ok;
}

inline haptics::BusResult EmulatedBus::write(std::span<const std::uint8_t> bytes, int wait_ms,
                                             std::string& why) {
    if (world_->falcon.faults.deaf) {
        world_->pass(wait_ms * kMs);
        return haptics::BusResult::late;
    }
    world_->pass(kMs / 8);
    world_->falcon.bulkOut(bytes, world_->now_ns);
    if (!world_->falcon.faults.unplugged) return haptics::BusResult::ok;
    why = "it was unplugged";
    return haptics::BusResult::lost;
}

inline haptics::BusResult EmulatedBus::read(haptics::BusBytes& got, int wait_ms, std::string& why) {
    FalconEmulator& falcon = world_->falcon;
    got.count = 0;
    if (falcon.faults.mute) {
        world_->pass(wait_ms * kMs);
        return haptics::BusResult::late;
    }
    world_->pass(falcon.hasData() ? kMs / 2 : std::min(falcon.latencyMs(), wait_ms) * kMs);
    if (falcon.faults.unplugged) {
        why = "it was unplugged";
        return haptics::BusResult::lost;
    }
    const std::vector<std::uint8_t> packet = falcon.bulkIn();
    got.count = packet.size() - 2;
    std::copy(packet.begin() + 2, packet.end(), got.bytes.begin());
    return haptics::BusResult::ok;
}

inline void EmulatedBus::close() noexcept {
    world_->pass(kMs / 8);
}

}  // namespace stylet::test
