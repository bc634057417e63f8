// What a start takes, part by part, and what it had to make because no earlier one had kept it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace stylet::trainer {

using SteadyTime = std::chrono::steady_clock::time_point;

inline double secondsBetween(SteadyTime begin, SteadyTime end) {
    return std::chrono::duration<double>(end - begin).count();
}

// Zero of each where the cache is warm.
struct Made {
    unsigned patients = 0, marks = 0, plans = 0, touch_maps = 0;
};

// When the first picture was drawn, and what of Vulkan was made until then.
struct FirstPicture {
    SteadyTime at;
    std::uint64_t pipelines = 0;
    double pipelines_ms = 0.0;
    std::size_t kept_pipeline_bytes = 0;  // that the driver was given of an earlier start's
};

struct Start {
    SteadyTime begun{};  // the program, or an attempt after its first
    // One after the other, each until it was over.
    SteadyTime asked{};     // what is wanted is known
    SteadyTime patient{};   // he is there, and the path into him
    SteadyTime hand{};      // so is what moves the tool, and what it presses on
    SteadyTime pictures{};  // headset or window, device, scene
    Made made{};
};

}  // namespace stylet::trainer
