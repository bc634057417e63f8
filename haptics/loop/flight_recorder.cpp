#include "haptics/loop/flight_recorder.h"

#include <algorithm>
#include <cmath>

namespace stylet::haptics {

FlightRecorder::FlightRecorder(double dt_s) : after_(std::size_t(std::llround(kFlightAfter_s / dt_s))) {
    for (Tape& tape : tapes_)
        tape.ticks.resize(std::size_t(std::llround(kFlightBefore_s / dt_s)) + after_);
}

void FlightRecorder::log(const TickRecord& record) noexcept {
    Tape& tape = tapes_[std::size_t(running_)];
    tape.ticks[tape.next] = record;
    tape.next = tape.next + 1 == tape.ticks.size() ? 0 : tape.next + 1;
    tape.count = std::min(tape.count + 1, tape.ticks.size());

    const std::uint32_t faults = record.output.faults;
    const bool fresh = (faults & ~last_faults_) != 0;
    last_faults_ = faults;
    if (countdown_ > 0) {
        if (--countdown_ == 0) publishTape();
    } else if (fresh) {
        countdown_ = after_;
    }
}

void FlightRecorder::finish() noexcept {
    if (countdown_ > 0) publishTape();
    countdown_ = 0;
}

// Passes the running tape to the consumer thread and continues on the other tape.
void FlightRecorder::publishTape() noexcept {
    if (full_.load(std::memory_order_acquire) != kNone) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        return;
    }
    full_.store(running_, std::memory_order_release);
    running_ = 1 - running_;
    tapes_[std::size_t(running_)].next = tapes_[std::size_t(running_)].count = 0;
}

bool FlightRecorder::pop(std::vector<TickRecord>& flight) {
    const int full = full_.load(std::memory_order_acquire);
    if (full == kNone) return false;
    const Tape& tape = tapes_[std::size_t(full)];
    flight.clear();
    const std::size_t size = tape.ticks.size(), first = (tape.next + size - tape.count) % size;
    for (std::size_t i = 0; i < tape.count; ++i)
        flight.push_back(tape.ticks[(first + i) % size]);
    full_.store(kNone, std::memory_order_release);
    return true;
}

}  // namespace stylet::haptics
