// Puncture needles by gauge (assets/instruments/needles.toml).
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace stylet::haptics {

inline constexpr int kDefaultGauge = 17;

struct NeedleGauge {
    int gauge = kDefaultGauge;
    double outer_m = 0.0;  // outer diameter; becomes NeedleSettings::cut_reach_m
};

// Both throw DataError for an invalid field, a duplicate gauge, or a gauge that the file does not contain.
std::vector<NeedleGauge> parseGauges(const std::filesystem::path& file, std::string_view toml);
NeedleGauge loadGauge(const std::filesystem::path& toml, int gauge);

}  // namespace stylet::haptics
