// The bridge's side of the protocol, for a program that wraps a closed SDK. The SDK's servo thread calls
// Servo::tick(). serve() (serve_linux.h) talks to Stylet on a separate thread, so that neither a slow socket
// nor a crashed trainer can leave a force on the device.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "base/rings.h"
#include "haptics/devices/bridge/protocol.h"

namespace stylet::haptics::bridge {

// Device state read by the SDK in one servo tick. Metres, newtons, the device's own frame.
struct Sample {
    std::int64_t sampled_ns = 0;  // CLOCK_MONOTONIC
    Pose device_from_stylus;
    std::uint32_t buttons = 0;
    MotorStage motors = MotorStage::on;
    bool hand_on = true;
};

class Servo {
  public:
    // Servo thread. Wait-free. Publishes the sample and returns the force to apply in this tick, at most
    // `force_peak_n`. The force is zero if the newest command is older than 15 ms, and then stays zero until
    // a command of exactly zero arrives.
    Vec3 tick(const Sample&, double force_peak_n) noexcept;
    // SDK's threads. Reports the device as lost. `why` must have static lifetime.
    void fail(const char* why) noexcept { failure_.store(why); }

    // Server's thread.
    void command(const Force& force) noexcept { commands_.publish({force, true}); }
    void release() noexcept { commands_.publish({}); }  // Stylet has disconnected: zero force now
    bool readSample(Sample&, bool& watchdog) noexcept;  // false if there is no sample yet
    const char* failure() const noexcept { return failure_.load(); }

  private:
    struct Command {
        Force force;
        bool live = false;
    };
    struct Published {
        Sample sample;
        bool watchdog = true, any = false;
    };
    Snapshot<Command> commands_;
    Snapshot<Published> samples_;
    std::atomic<const char*> failure_{nullptr};
    bool tripped_ = true;  // servo thread only
};

// One connection: bytes in, bytes out. No I/O.
class Session {
  public:
    Session(const Capabilities& capabilities, Servo& servo) : capabilities_(capabilities), servo_(servo) {}
    // Processes received bytes and appends the answers to `out`. Returns false if the caller must send `out`
    // and hang up.
    bool receive(std::span<const std::uint8_t>, std::vector<std::uint8_t>& out);
    // Appends a bye frame.
    void end(std::string_view reason, std::vector<std::uint8_t>& out);

  private:
    bool handle(const Frame&, std::vector<std::uint8_t>& out);
    bool refuse(LinkFault fault, std::vector<std::uint8_t>& out);

    const Capabilities& capabilities_;
    Servo& servo_;
    std::vector<std::uint8_t> buffered_;
    std::uint32_t sent_ = 0, last_sequence_ = 0;
    bool greeted_ = false;
};

}  // namespace stylet::haptics::bridge
