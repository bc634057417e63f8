// A device trace: stylus poses and commands over time, scripted or recorded. One sample per tick, or fewer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "haptics/loop/simulation.h"

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

// Returns the stylus at time t. Positions are interpolated linearly and rotations by normalised lerp;
// before the first and after the last sample the pose is constant. noexcept, no allocation. `hint` is the
// caller's cursor; it makes a forward sweep O(1) per call.
TraceSample sampleAt(const Trace&, std::int64_t t_ns, std::size_t& hint) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
