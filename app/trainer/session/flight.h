// Writes the flight recorder's history of a fault as a CSV file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "haptics/loop/flight_recorder.h"

namespace stylet::trainer {

// Names of the set bits, for example "bad-pose+device-lost"; "none" for 0.
std::string faultNames(std::uint32_t faults);

// Writes one line per tick. t_s = 0 is the tick in which the first new fault appeared. Throws
// DataError.
void writeFlight(const std::vector<haptics::TickRecord>&, double dt_s, const std::filesystem::path& csv);

}  // namespace stylet::trainer
