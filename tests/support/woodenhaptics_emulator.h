// Emulates the firmware of a WoodenHaptics board: it sends a report, waits for a command, executes it, and
// sends the next report. After forsslund/haptikfabrikenapi, firmware/main.cpp.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/support/hid_testbed.h"

namespace stylet::test {

class WoodenHapticsEmulator {
  public:
    enum class Fault {
        none,
        drop,       // no report after a command
        duplicate,  // each report is sent twice
        corrupt,    // random words instead of the encoder values
        cut,        // a report without its last bytes
        deaf,       // neither reads nor answers
    };

    WoodenHapticsEmulator();
    ~WoodenHapticsEmulator();

    void moveTo(const std::array<std::int16_t, 3>& encoders);
    void turnWristTo(const std::array<std::int16_t, 3>& encoders);  // d, e, f
    void pressButton();
    void inject(Fault fault) { fault_.store(fault); }
    void injectButton() { garbled_button_.store(true); }  // in one report
    std::array<std::int16_t, 6> encoders() const;
    void unplug();
    // The driver's next write blocks until unplug().
    void block();

    struct CommandLog {
        std::array<int, 3> motor_ma{};
        std::uint64_t commands = 0;
        std::uint64_t powered = 0;  // commands with any current
        std::uint64_t calibrations = 0;
        int largest_ma = 0;
        bool malformed = false;  // received an unknown report id or command
    };
    CommandLog commandLog() const;
    // For a test that runs the driver on its own thread, which may be faster than the emulator's thread.
    std::uint64_t received() const { return received_.load(); }  // commands executed and answered
    bool waiting() const { return node_.waiting() > 0; }         // the driver has not read a report yet
    bool sending() const { return sending_.load(); }             // until the driver has read the report
    bool isResponsive() const { return !stop_.load() && fault_.load() != Fault::deaf; }

  private:
    void run();
    void stop();
    void execute(const std::vector<unsigned char>& command);
    bool report();
    bool sendLast();

    HidNode node_;
    mutable std::mutex mutex_;  // guards the members below
    std::array<std::int16_t, 6> encoders_{};
    bool button_ = false;
    CommandLog command_log_;
    std::uint32_t noise_ = 1;
    std::vector<unsigned char> last_;  // last report; used only by the board's thread
    std::atomic<std::uint64_t> received_{0};
    std::atomic<Fault> fault_{Fault::none};
    std::atomic<bool> garbled_button_{false};
    std::atomic<bool> stop_{false}, sending_{false};
    std::thread thread_;
};

}  // namespace stylet::test
