// The five tools, and what the model of each says of a tick.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "patient/geometry.h"

namespace stylet::haptics {

// In the order of the procedure. The guide steers the needle; the probe stays where it is parked.
enum class Tool : std::uint8_t { finger, probe, scalpel, guide, needle };
inline constexpr int kToolCount = 5;
inline constexpr std::array<std::string_view, kToolCount> kToolNames{"finger", "probe", "scalpel", "guide",
                                                                     "needle"};

// One tick of a tool, patient frame. The output stage's observer needs the last three (model, section 4).
struct ToolForce {
    patient::Vec3 force_n{0.0};
    patient::Vec3 torque_n_m{0.0};      // about the tool's tip
    patient::Vec3 tissue_moved_m{0.0};  // by the tissue at the tip in this tick: the breath
    double energy_j = 0.0;              // S, in the model's springs at the tick's end
    bool event = false;                 // the force may step: a cut, a tissue entered, a tool taken up
};

}  // namespace stylet::haptics
