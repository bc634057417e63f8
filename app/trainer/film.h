// `stylet film`: how a scenario's patient breathes, as a table, a curve and a film.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace stylet::trainer {

struct FilmOptions {
    std::string scenario = "demo";    // a name in assets/scenarios, or a .toml file
    std::filesystem::path patient;    // empty: the reference patient of `seed`
    std::uint64_t seed = 1;           // of patient and breath
    double spacing_mm = 1.0;          // of a reference patient made here
    std::filesystem::path recording;  // CSV of a marker's track in place of the scenario's rhythm
    int frames = 24;
    std::optional<double> seconds;  // of the film; absent: one breath
    bool stereo = true;             // the eyes' pictures too, where there is a GPU
    std::filesystem::path out;
};

// breath.csv and breath.png over the whole scenario; coronal.png, coronal-NNN.png, stereo.png and
// stereo-NNN.png over the film; puncture.png and puncture-NNN.png about the first cut of the skin. The exit
// status of the command. Throws patient::DataError.
int film(const FilmOptions&);

}  // namespace stylet::trainer
