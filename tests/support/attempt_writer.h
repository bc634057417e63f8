// The data that stylet-attempt-writer stores for a tick, so that tests can check it afterwards.
#pragma once

#include <cstdint>
#include <string>

#include "app/records/samples.h"
#include "haptics/loop/simulation.h"

namespace stylet::test {

inline constexpr const char* kWriterSeed = "STYLET_ATTEMPT_WRITER_SEED";

inline haptics::TickInput inputAt(std::uint64_t tick) {
    haptics::TickInput input;
    input.device.device_from_stylus.position_m = {double(tick), 1.0, -1.0};
    input.device.fresh = 1;
    return input;
}

inline std::uint64_t hashAt(std::uint64_t tick) {
    return tick * 0x9e3779b97f4a7c15ull;
}

inline records::Sample sampleAt(std::uint64_t tick) {
    records::Sample sample;
    sample.tick = tick;
    sample.depth_m = double(tick);
    sample.faults = std::uint32_t(tick * 2654435761u);
    return sample;
}

inline std::string textAt(std::uint64_t tick) {
    return "at tick " + std::to_string(tick);
}

}  // namespace stylet::test
