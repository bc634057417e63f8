// The last two seconds before a fault, and a tenth after it, tick by tick. Filled on the haptics thread; a
// fault hands it to another thread, which is in no hurry.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "haptics/simulation.h"

namespace stylet::haptics {

// One tick as the session gets it: what went in and what came out.
struct TickRecord {
    TickInput input;
    TickOutput output;
};

inline constexpr double kFlightBefore_s = 2.0, kFlightAfter_s = 0.1;

class FlightRecorder {
  public:
    explicit FlightRecorder(double dt_s);

    // Haptics thread. Wait-free, no allocation. A new fault bit starts the countdown to a flight.
    void log(const TickRecord&) noexcept STYLET_NONBLOCKING;
    // Haptics thread, or whoever comes after it has ended: a flight whose countdown still runs ends here.
    void finish() noexcept;

    // One other thread. The oldest flight not yet taken, first tick first; false when there is none.
    bool take(std::vector<TickRecord>& flight);
    // Faults whose flight found the last one not taken yet.
    std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }

  private:
    void hand() noexcept STYLET_NONBLOCKING;

    struct Tape {
        std::vector<TickRecord> ticks;
        std::size_t next = 0, count = 0;
    };
    static constexpr int kNone = -1;

    std::array<Tape, 2> tapes_;
    int running_ = 0;
    std::uint32_t seen_faults_ = 0;
    std::size_t after_ = 0, countdown_ = 0;
    std::atomic<int> full_{kNone};  // the tape that waits to be taken
    std::atomic<std::uint64_t> missed_{0};
};

}  // namespace stylet::haptics
