// `stylet film`: writes the breathing of a scenario's patient as a table, a curve and a film.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace stylet::trainer {

struct FilmOptions {
    std::string scenario = "demo";    // name in assets/scenarios, or a .toml file
    std::filesystem::path patient;    // empty: the reference patient of `seed`
    std::uint64_t seed = 1;           // for patient and breath
    double spacing_mm = 1.0;          // voxel size of a generated reference patient
    std::filesystem::path recording;  // CSV of a marker track, replaces the scenario's rhythm
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
