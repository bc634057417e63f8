#include "haptics/devices/falcon/falcon_calibration.h"

#include <toml++/toml.h>

#include <cmath>
#include <fstream>

#include "base/fields.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::haptics::falcon {

namespace {

// The public driver's gain may be off by a factor of up to four. Beyond a factor of ten something else must
// be wrong.
constexpr double kMinGain = 0.1, kMaxGain = 10.0;
constexpr std::size_t kMaxCalibrationBytes = 16 * 1024;
constexpr std::size_t kMaxTextLength = 400;

// An unused file name beside `file`.
std::filesystem::path unusedSibling(const std::filesystem::path& file) {
    std::filesystem::path fresh = file.string() + ".new";
    std::error_code error;
    for (int i = 2; std::filesystem::exists(std::filesystem::symlink_status(fresh, error)); ++i)
        fresh = file.string() + ".new" + std::to_string(i);
    return fresh;
}

}  // namespace

double fitCalibration(std::span<const CalibrationReading> readings, const std::string& axis) {
    if (readings.size() < 2) throw DataError("calibration", axis, "needs two readings or more");
    double products = 0.0, squares = 0.0;
    for (const CalibrationReading& r : readings) {
        if (!std::isfinite(r.commanded_n) || !std::isfinite(r.measured_n) || r.commanded_n == 0.0)
            throw DataError("calibration", axis, "a reading must be a number, of a force that is not zero");
        products += r.commanded_n * r.measured_n;
        squares += r.commanded_n * r.commanded_n;
    }
    const double slope = products / squares;
    if (!(slope >= kMinGain && slope <= kMaxGain))
        throw DataError("calibration", axis,
                        "measures less than a tenth or more than ten times what was asked");
    for (const CalibrationReading& r : readings)
        if (std::fabs(r.measured_n - slope * r.commanded_n) > 0.2 * std::fabs(slope * r.commanded_n))
            throw DataError("calibration", axis, "the readings lie on no line through zero: measure again");
    return slope;
}

Calibration loadCalibration(const std::filesystem::path& file) {
    return parseCalibration(readWholeFile(file, kMaxCalibrationBytes), file);
}

Calibration parseCalibration(std::string_view text, const std::filesystem::path& file) {
    Fields in = parseToml(file, text);
    if (in.text("device") != "falcon") in.refuse("device", "must be \"falcon\"");
    Calibration calibration;
    calibration.measured = true;
    calibration.measured_per_asked = in.vector("measured_per_asked", kMinGain, kMaxGain);
    calibration.how = in.textOr("how", "", kMaxTextLength);
    in.finish();
    return calibration;
}

void saveCalibration(const std::filesystem::path& file, const Calibration& calibration) {
    const Vec3& gain = calibration.measured_per_asked;
    const toml::table table{{"device", "falcon"},
                            {"measured_per_asked", toml::array{gain.x, gain.y, gain.z}},
                            {"how", calibration.how}};
    const std::filesystem::path fresh = unusedSibling(file);
    std::ofstream out(fresh);
    out << table << '\n';
    out.close();
    std::error_code error, ignored;
    if (out) std::filesystem::rename(fresh, file, error);
    if (out && !error) return;
    std::filesystem::remove(fresh, ignored);
    throw DataError(file, "calibration", "could not be written");
}

void checkCalibrationFile(const std::filesystem::path& file) {
    const std::filesystem::path fresh = unusedSibling(file);
    const bool opens = bool(std::ofstream(fresh));
    std::error_code error;
    std::filesystem::remove(fresh, error);
    if (!opens || std::filesystem::is_directory(file, error))
        throw DataError(file, "calibration", "cannot be written");
}

}  // namespace stylet::haptics::falcon
