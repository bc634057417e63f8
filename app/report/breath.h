// The breath on paper: how far the liver's dome moves against the signal that drives it.
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
    double dome_m = 0.0;  // below its place at end-exhale
};

// Where the motion is looked at, reference patient: the top of the liver; where nothing is labelled as liver
// the place within the cavity, on what is tissue all the way from the feet, that goes down farthest.
patient::Vec3 domePoint(const patient::Patient&);
// How far that point lies below its place at end-exhale.
double domeBelowExhale_m(const patient::Patient&, const patient::Surrogate&, const patient::Vec3& dome_m);

// How the dome follows, over the samples that are not held.
struct DomeFollows {
    double correlation = 0.0, travel_m = 0.0, per_v_m = 0.0;  // the last: slope of the line through them
    double off_line_m = 0.0;  // root of the mean square beside that line: hysteresis and clamp
    double held_from_m = 0.0, held_to_m = 0.0;  // the dome over all samples that are held
};
DomeFollows domeFollows(const std::vector<BreathSample>&);

// Columns time_s, v, rate_per_s, creep_v, held, dome_mm. Throws patient::DataError.
void writeBreathCsv(const std::vector<BreathSample>&, const std::filesystem::path&);

// Dome and signal over time, and the one over the other. Throws patient::DataError.
void drawBreath(const std::vector<BreathSample>&, const std::string& title, const std::string& signal,
                const std::filesystem::path& png);

}  // namespace stylet::report
