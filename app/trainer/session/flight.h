// Writes the flight recorder's history of a fault as a CSV file.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "haptics/loop/flight_recorder.h"

namespace stylet::trainer {

// Indexed by haptics::ForceStage.
inline constexpr std::array<std::string_view, 5> kForceStageNames{"waiting", "rising", "on", "fading", "off"};

// Names or explanations of the set bits. Empty for 0.
inline std::string joinFaults(std::uint32_t faults, const char* separator,
                              const char* haptics::FaultText::* text) {
    std::string joined;
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((faults & fault.bit) != 0) joined += (joined.empty() ? "" : separator) + std::string(fault.*text);
    return joined;
}
// Names of the set bits, for example "bad-pose+device-lost"; "none" for 0.
inline std::string faultNames(std::uint32_t faults) {
    return faults == 0 ? "none" : joinFaults(faults, "+", &haptics::FaultText::name);
}

// Writes one line per tick. t_s = 0 is the tick in which the first new fault appeared. Throws
// DataError.
void writeFlight(const std::vector<haptics::TickRecord>&, double dt_s, const std::filesystem::path& csv);

}  // namespace stylet::trainer
