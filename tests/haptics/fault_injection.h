// Injects faults into a running output stage, or into a whole simulation, at random times. Each fault must
// end in zero force within 20 ms and must be reported by name. Shared by test and bench.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "haptics/haptics.h"

namespace stylet::test {

enum class Injected : std::uint8_t {
    unplugged,
    handOff,
    focusLost,
    poseNotFinite,
    rotationNotUnit,
    farAway,
    leap,
    outOfReach,
    silence,
    forceNotFinite,  // the last three are faults of the force model: output stage only
    tissueNotFinite,
    energyNotFinite
};
inline constexpr int kInjectedCount = 12;
const char* injectedName(Injected);

struct InjectionTotals {
    std::uint64_t injections = 0, failures = 0;
    std::array<std::uint64_t, kInjectedCount> by_cause{};
    std::array<double, kInjectedCount> slowest_s{};  // from the first bad tick to the last force
    double slowest() const;
    std::string first_failure;
};

// Runs at 1, 2 and 4 kHz on three devices, at any level of the start ramp, with moving springs and
// breathing. Faults last from one tick to forever.
InjectionTotals injectIntoOutput(std::uint64_t count, std::uint64_t seed);
// Runs at 1 kHz through needle, breathing and registration, at times throughout the scripted puncture.
InjectionTotals injectIntoSimulation(std::uint64_t count, std::uint64_t seed);

}  // namespace stylet::test
