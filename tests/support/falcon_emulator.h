// Emulates a Novint Falcon byte by byte: the FTDI chip's requests and pipes, the firmware loader, the running
// firmware, and the hand on the device. It was written from the description of the protocol and shares no
// code with the driver.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace stylet::test {

class FalconEmulator {
  public:
    // Faults. Each lasts until its count is used up or the test resets it.
    struct Faults {
        bool unplugged = false;
        bool deaf = false;    // accepts no OUT data: the pipe is never ready
        bool mute = false;    // the IN pipe returns nothing, not even status
        bool silent = false;  // the chip returns its status, but the firmware does not reply
        int drop = 0;         // replies that are lost
        int repeat = 0;       // replies that are sent twice
        int cut = 0;          // replies that lose their fifth byte
        int late = 0;         // replies that are delayed until the next command
        int xor_count = 0;    // replies in which byte `xor_byte` is changed
        int xor_byte = 0;
        std::uint8_t xor_mask = 0;
        int unplug_after_bytes = -1;  // unplugs in the middle of a write, after this many bytes
        bool never_greets = false;
        int wrong_echoes = 0, no_echoes = 0;
    };

    explicit FalconEmulator(bool has_firmware) : running_(has_firmware) {}

    // The USB cable. The caller passes the time [ns]; the emulator has no clock.
    void control(std::uint8_t request, std::uint16_t value);
    void bulkOut(std::span<const std::uint8_t> bytes, std::int64_t t_ns);
    // Returns the bytes of an IN transfer of up to 64 bytes: two status bytes and the pending data.
    std::vector<std::uint8_t> bulkIn();
    bool hasData() const { return !to_host_.empty(); }
    int latencyMs() const { return latency_ms_; }

    // The hand on the device, and its visible state.
    void moveTo(const std::array<int, 3>& counts) { counts_ = counts; }
    void home() { homed_ = homing_ ? 7 : homed_; }
    void powerCycle();
    void unhome() { homed_ = 0; }
    void press(std::uint8_t buttons) { buttons_ = buttons; }
    const std::array<int, 3>& motors() const { return motors_; }
    bool hasMotorForce() const { return motors_[0] != 0 || motors_[1] != 0 || motors_[2] != 0; }
    bool hasFirmware() const { return running_; }
    const std::vector<std::uint8_t>& image() const { return image_; }
    std::size_t image_bytes = 7914;  // the firmware runs once it has received this many bytes
    int packets = 0;                 // complete packets from the host
    int bad_packets = 0;             // malformed packets
    int leds() const { return leds_; }

    Faults faults;

  private:
    void loaderByte(std::uint8_t byte);
    void firmwareByte(std::uint8_t byte, std::int64_t t_ns);
    void processPacket();
    void reply();
    void queue(std::vector<std::uint8_t> bytes);

    bool running_;
    int baud_ = 0, latency_ms_ = 16, line_ = 0;
    bool data_terminal_ready_ = false, reset_seen_ = false;
    enum class Loader { waiting, greeted, loading } loader_ = Loader::waiting;
    std::vector<std::uint8_t> greeting_, packet_, image_, late_;
    std::deque<std::uint8_t> to_host_;
    std::array<int, 3> motors_{}, counts_{-516, -516, -516};
    bool homing_ = false;
    int homed_ = 0, leds_ = 0;
    std::uint8_t buttons_ = 0;
};

}  // namespace stylet::test
