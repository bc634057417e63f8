// What one newton asked of a Falcon comes to at its grip. The public driver's gain is undocumented and may be
// two to four times off; how to measure is in README.md.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "patient/geometry.h"

namespace stylet::haptics::falcon {

struct Calibration {
    patient::Vec3 measured_per_asked{1.0};  // N/N, along x, y, z
    bool measured = false;                  // false: nobody has
    std::string how;                        // in the user's words: scale, mass, date
};

// One reading along one axis: the force asked for with gains of one, and what the scale said.
struct CalibrationReading {
    double asked_n = 0.0, measured_n = 0.0;
};

// The line through the origin of least squares. Throws patient::DataError (in the name of `axis`) for fewer
// than two readings, a reading that is not finite, or a line that misses one by more than a fifth.
double fitCalibration(std::span<const CalibrationReading>, const std::string& axis);

// TOML; refuses by throwing patient::DataError with file, field and reason.
Calibration loadCalibration(const std::filesystem::path&);
// `file` is only named in refusals.
Calibration parseCalibration(std::string_view text, const std::filesystem::path& file);
// The file is replaced in one step: a calibration that cannot be written leaves the old one.
void saveCalibration(const std::filesystem::path&, const Calibration&);
// Throws where that could not be written.
void checkCalibrationFile(const std::filesystem::path&);

}  // namespace stylet::haptics::falcon
