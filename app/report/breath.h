// Plots of breathing: the motion of the liver's dome against the signal that drives it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patient/patient.h"

namespace stylet::report {

struct BreathSample {
    double t_s = 0.0;
    patient::Surrogate breath;
    bool held = false;
    double dome_m = 0.0;  // below its position at end-exhale
};

// The point whose motion is shown, in the reference patient: the top of the liver. Without a liver label:
// the point inside the cavity that moves down farthest, with tissue all the way below it.
Vec3 domePoint(const patient::Patient&);
// Distance of that point below its position at end-exhale.
double domeBelowExhale_m(const patient::Patient&, const patient::Surrogate&, const Vec3& dome_m);

// How closely the dome follows the signal, over the samples without breath-hold.
struct DomeRegression {
    double correlation = 0.0, travel_m = 0.0, slope_m = 0.0;  // slope_m: slope of the regression line
    double residual_rms_m = 0.0;                // RMS deviation from that line: hysteresis and clamping
    double held_from_m = 0.0, held_to_m = 0.0;  // range of the dome over the breath-hold samples
};
DomeRegression fitDomeMotion(const std::vector<BreathSample>&);

// Columns time_s, v, rate_per_s, creep_v, held, dome_mm. Throws DataError.
void writeBreathCsv(const std::vector<BreathSample>&, const std::filesystem::path&);

// Draws dome and signal over time, and the dome over the signal. Throws DataError.
void drawBreath(const std::vector<BreathSample>&, const std::string& title, const std::string& signal,
                const std::filesystem::path& png);

}  // namespace stylet::report
