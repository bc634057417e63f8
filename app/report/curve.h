// Force over depth as a picture. app/records/export.h writes the numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/tools/force_sample.h"

namespace stylet::report {

using haptics::ForceSample;

// A puncture to mark in the picture.
struct ForceMark {
    std::string text;
    double depth_m = 0.0, force_n = 0.0;
};

// Draws the insertion in a strong colour, the withdrawal in a faint one, and the tissues as bands in the
// background. Throws DataError.
void drawCurve(const std::vector<ForceSample>&, const std::vector<ForceMark>&, const std::string& title,
               const std::filesystem::path& png);

}  // namespace stylet::report
