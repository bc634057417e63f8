// The flight recorder's history of a fault, for a person and a spreadsheet.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "haptics/flight_recorder.h"

namespace stylet::trainer {

// The names of the bits, "bad-pose+device-lost"; "none" for 0.
std::string faultNames(std::uint32_t faults);

// One line a tick; t_s = 0 where the last new fault was seen. Throws patient::DataError.
void writeFlight(const std::vector<haptics::TickRecord>&, double dt_s, const std::filesystem::path& csv);

}  // namespace stylet::trainer
