// A device trace: the hand and the commands over time, scripted or recorded, one sample a tick or sparser.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "haptics/simulation.h"

namespace stylet::haptics {

struct TraceSample {
    std::int64_t t_ns = 0;
    Pose device_from_stylus;
    std::uint32_t buttons = 0;
};
struct TraceCommand {
    std::int64_t t_ns = 0;
    Command command;
};
struct Trace {
    std::vector<TraceSample> samples;    // ascending t
    std::vector<TraceCommand> commands;  // ascending t
};

// The hand at t: linear between samples (normalised linear for rotations), the ends held. noexcept, no
// allocation. `hint` is the caller's cursor: keeps a forward sweep O(1).
TraceSample sampleAt(const Trace&, std::int64_t t_ns, std::size_t& hint) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
