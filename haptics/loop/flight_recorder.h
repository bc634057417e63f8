// Records every tick from two seconds before a fault to 0.1 s after it. Filled on the haptics thread; after
// a fault the recording is passed to another thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "haptics/loop/simulation.h"

namespace stylet::haptics {

// Input and output of one tick.
struct TickRecord {
    TickInput input;
    TickOutput output;
};

inline constexpr double kFlightBefore_s = 2.0, kFlightAfter_s = 0.1;

class FlightRecorder {
  public:
    explicit FlightRecorder(double dt_s);

    // Haptics thread. Wait-free, no allocation. A new fault bit starts the countdown that ends a recording.
    void log(const TickRecord&) noexcept STYLET_NONBLOCKING;
    // Haptics thread, or any thread after the haptics thread has ended. Ends a recording whose countdown is
    // still running.
    void finish() noexcept;

    // One consumer thread. Pops the recording into `flight`, oldest tick first. Returns false if there is
    // none.
    bool pop(std::vector<TickRecord>& flight);
    // Recordings dropped because the previous one had not been consumed.
    std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

  private:
    void publishTape() noexcept STYLET_NONBLOCKING;

    struct Tape {
        std::vector<TickRecord> ticks;
        std::size_t next = 0, count = 0;
    };
    static constexpr int kNone = -1;

    std::array<Tape, 2> tapes_;
    int running_ = 0;
    std::uint32_t last_faults_ = 0;
    std::size_t after_ = 0, countdown_ = 0;
    std::atomic<int> full_{kNone};  // the tape waiting for the consumer
    std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace stylet::haptics
