// Force over depth, as numbers and as a picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/tools/needle.h"

namespace stylet::report {

// One tick inside the body.
struct ForceSample {
    std::uint64_t tick = 0;
    double depth_m = 0.0;  // of the tip along the track, from the skin
    double force_n = 0.0;  // axial, > 0 resists insertion
    haptics::Phase phase = haptics::Phase::outside;
    haptics::Tissue tissue = haptics::Tissue::air;
    bool breath_held = false;
};

// A puncture to mark in the picture.
struct ForceMark {
    std::string text;
    double depth_m = 0.0, force_n = 0.0;
};

// Columns tick, time_s, depth_m, force_n, phase, tissue, breath_held. Throws DataError.
void writeCurveCsv(const std::vector<ForceSample>&, double dt_s, const std::filesystem::path&);

// Draws the insertion in a strong colour, the withdrawal in a faint one, and the tissues as bands in the
// background. Throws DataError.
void drawCurve(const std::vector<ForceSample>&, const std::vector<ForceMark>&, const std::string& title,
               const std::filesystem::path& png);

}  // namespace stylet::report
