// A Novint Falcon byte by byte, as far as its cable: the FTDI chip's requests and pipes, the firmware's
// loader, the running firmware, and what a hand may do to it. Written from the description of the protocol;
// it shares nothing with the driver.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace stylet::test {

class FalconEmulator {
  public:
    // Faults: each stands until it is used up or taken back.
    struct Faults {
        bool unplugged = false;
        bool deaf = false;    // takes no OUT data: the pipe is never ready
        bool mute = false;    // the IN pipe answers nothing, not even status
        bool silent = false;  // the chip tells its status, the firmware does not reply
        int drop = 0;         // replies that vanish
        int repeat = 0;       // replies that come twice
        int cut = 0;          // replies that lose their fifth byte
        int late = 0;         // replies that come with the next command
        int xor_count = 0;    // replies of which byte `xor_byte` is changed
        int xor_byte = 0;
        std::uint8_t xor_mask = 0;
        int unplug_after_bytes = -1;  // in the middle of a write
        bool never_greets = false;
        int wrong_echoes = 0, no_echoes = 0;
    };

    explicit FalconEmulator(bool has_firmware) : running_(has_firmware) {}

    // The cable. Time in ns; only told, never read.
    void control(std::uint8_t request, std::uint16_t value);
    void bulkOut(std::span<const std::uint8_t> bytes, std::int64_t t_ns);
    // What an IN transfer of 64 bytes returns now: two status bytes and what there is.
    std::vector<std::uint8_t> bulkIn();
    bool hasData() const { return !to_host_.empty(); }
    int latencyMs() const { return latency_ms_; }

    // The hand and the eye.
    void holdAt(const std::array<int, 3>& counts) { counts_ = counts; }
    void home() { homed_ = homing_ ? 7 : homed_; }
    void powerCycle();
    void unhome() { homed_ = 0; }
    void press(std::uint8_t buttons) { buttons_ = buttons; }
    const std::array<int, 3>& motors() const { return motors_; }
    bool pushes() const { return motors_[0] != 0 || motors_[1] != 0 || motors_[2] != 0; }
    bool hasFirmware() const { return running_; }
    const std::vector<std::uint8_t>& image() const { return image_; }
    std::size_t image_bytes = 7914;  // it runs once it has as many
    int packets = 0;                 // whole ones from the host
    int bad_packets = 0;             // what was none
    int leds() const { return leds_; }

    Faults faults;

  private:
    void loaderByte(std::uint8_t byte);
    void firmwareByte(std::uint8_t byte, std::int64_t t_ns);
    void takePacket();
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
