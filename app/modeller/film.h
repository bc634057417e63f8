// A film of the breath: coronal slices of the deformed patient, and how far the dome moves against the
// signal.
#pragma once

#include <filesystem>
#include <vector>

#include "app/modeller/slices.h"
#include "patient/patient.h"

namespace stylet::modeller {

// One coronal slice of the patient in this breath, y in the patient frame; the cavity's surface drawn in.
Picture breathingSlice(const patient::Package&, const patient::Surrogate&, double y_m, const Window&);

// What one frame of the film shows.
struct FilmMoment {
    double t_s = 0.0;
    patient::Surrogate breath;
    double dome_m = 0.0;  // how far the liver's dome lies below its place at end-exhale
};

struct Film {
    double y_m = 0.0;  // the slice: through the liver's middle
    std::vector<FilmMoment> moments;
};

// `frames` moments spread over one breath of the plan, or over its first `seconds`.
Film planFilm(const patient::Package&, const patient::BreathPlan&, int frames, double seconds);

// frame-000.png ..., sheet.png (every frame, small, row by row) and dome.csv.
void writeFilm(const patient::Package&, const Film&, const std::filesystem::path& folder);

}  // namespace stylet::modeller
