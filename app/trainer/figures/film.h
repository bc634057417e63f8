// `stylet film`: writes the breathing of a scenario's patient as a table, a curve and a film.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/trainer/stores/patient_source.h"

namespace stylet::trainer {

struct FilmOptions {
    std::string scenario = "demo";  // name in assets/scenarios, or a .toml file
    PatientOptions source;
    std::filesystem::path recording;  // CSV of a marker's motion, which replaces the scenario's rhythm
    int frames = 24;
    std::optional<double> seconds;  // length of the film; absent: one breath
    bool stereo = true;             // also write stereo pictures, if there is a GPU
    std::filesystem::path out;
};

// Writes breath.csv and breath.png for the whole scenario; coronal.png, coronal-NNN.png, stereo.png and
// stereo-NNN.png for the film; puncture.png and puncture-NNN.png around the first cut of the skin. Returns
// the exit status. Throws DataError.
int film(const FilmOptions&);

}  // namespace stylet::trainer
