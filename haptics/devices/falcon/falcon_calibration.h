// Calibration of the Falcon's force: measured newtons per commanded newton at the grip. The public driver's
// gain is undocumented and may be off by a factor of two to four. haptics/devices/README.md describes how to
// measure it.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/geometry.h"

namespace stylet::haptics::falcon {

struct Calibration {
    Vec3 measured_per_asked{1.0};  // N/N, along x, y, z
    bool measured = false;         // false: not measured
    std::string how;               // free text by the user: scale, mass, date
};

// One reading along one axis: the force commanded with gains of one, and the force on the scale.
struct CalibrationReading {
    double commanded_n = 0.0, measured_n = 0.0;
};

// Least-squares line through the origin. Throws DataError (naming `axis`) for fewer than two
// readings, a reading that is not finite, or a line that misses a reading by more than a fifth.
double fitCalibration(std::span<const CalibrationReading>, const std::string& axis);

// Loads a TOML file. Throws DataError with file, field and reason.
Calibration loadCalibration(const std::filesystem::path&);
// `file` is used only in error messages.
Calibration parseCalibration(std::string_view text, const std::filesystem::path& file);
// Replaces the file atomically: if writing fails, the old calibration remains.
void saveCalibration(const std::filesystem::path&, const Calibration&);
// Throws if saveCalibration() could not write there.
void checkCalibrationFile(const std::filesystem::path&);

}  // namespace stylet::haptics::falcon
