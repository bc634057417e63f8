// The board of a WoodenHaptics as its firmware behaves: it sends a report, waits for a command, obeys, and
// sends the next. Facts from forsslund/haptikfabrikenapi, firmware/main.cpp.
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
        drop,       // no report for a command
        duplicate,  // each report twice
        corrupt,    // random words in place of the encoders
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

    struct Seen {
        std::array<int, 3> motor_ma{};
        std::uint64_t commands = 0;
        std::uint64_t powered = 0;  // commands with any current
        std::uint64_t calibrations = 0;
        int largest_ma = 0;
        bool malformed = false;  // a report id or a command that the board does not know
    };
    Seen seen() const;
    // For a driver on the test's thread, which otherwise may be faster than this one.
    std::uint64_t received() const { return received_.load(); }  // commands obeyed and answered
    bool waiting() const { return node_.waiting() > 0; }         // a report that the driver has not read
    bool sending() const { return sending_.load(); }             // until the driver has read what waits
    bool hears() const { return !stop_.load() && fault_.load() != Fault::deaf; }

  private:
    void run();
    void obey(const std::vector<unsigned char>& command);
    bool report();
    bool sendLast();

    HidNode node_;
    mutable std::mutex mutex_;  // all below
    std::array<std::int16_t, 6> encoders_{};
    bool button_ = false;
    Seen seen_;
    std::uint32_t noise_ = 1;
    std::vector<unsigned char> last_;  // report; the board's thread alone
    std::atomic<std::uint64_t> received_{0};
    std::atomic<Fault> fault_{Fault::none};
    std::atomic<bool> garbled_button_{false};
    std::atomic<bool> stop_{false}, sending_{false};
    std::thread thread_;
};

}  // namespace stylet::test
