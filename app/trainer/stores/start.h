// Start-up times, phase by phase, and the data that had to be generated because it was not cached.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace stylet::trainer {

using SteadyTime = std::chrono::steady_clock::time_point;

inline double secondsBetween(SteadyTime begin, SteadyTime end) {
    return std::chrono::duration<double>(end - begin).count();
}

// All zero if the cache is warm.
struct Made {
    unsigned patients = 0, marks = 0, plans = 0, touch_maps = 0;
};

// Time of the first picture, and the Vulkan pipelines created until then.
struct FirstPicture {
    SteadyTime at;
    std::uint64_t pipelines = 0;
    double pipelines_ms = 0.0;
    std::size_t kept_pipeline_bytes = 0;  // pipeline cache of an earlier start, given to the driver
};

struct Start {
    SteadyTime begun{};  // start of the program, or of a later attempt
    // Ends of the phases, in order.
    SteadyTime asked{};     // options and scenario read
    SteadyTime patient{};   // patient and path ready
    SteadyTime hand{};      // input and touch map ready
    SteadyTime pictures{};  // headset or window, GPU and scene ready
    Made made{};
};

}  // namespace stylet::trainer
