// The tools, and the result of one tick of a tool's force model.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "base/geometry.h"

namespace stylet::haptics {

// In the order of the procedure. With `guide` the needle is steered by the guide on the parked probe. The
// probe stays where it is parked.
// `wire` is the guide wire; dilator and drain slide over it.
enum class Tool : std::uint8_t { finger, probe, scalpel, guide, needle, wire, dilator, drain };
inline constexpr int kToolCount = 8;
inline constexpr std::array<std::string_view, kToolCount> kToolNames{"finger", "probe", "scalpel", "guide",
                                                                     "needle", "wire",  "dilator", "drain"};

// One tick of a tool, patient frame. The passivity observer in the output stage needs the last three
// members (model, section 4).
struct ToolForce {
    Vec3 force_n{0.0};
    Vec3 torque_n_m{0.0};      // about the tool's tip
    Vec3 tissue_moved_m{0.0};  // displacement of the tissue at the tip in this tick (breathing)
    double energy_j = 0.0;     // S: energy stored in the model's springs at the end of the tick
    bool event = false;        // the force may step: a puncture, a new tissue, a tool change
};

}  // namespace stylet::haptics
