// Films of the breathing patient: coronal slices breath by breath, and contact sheets of all frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "patient/patient.h"

namespace stylet::report {

struct FilmFrame {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // packed triples, rows from the top
    std::string caption;
};

// A coronal slice in radiological orientation, at most 0.6 mm per pixel. Labels are tinted. Lines mark the
// sliding surface of the motion model and the height `mark_z_m`.
FilmFrame coronalFrame(const patient::Patient&, const patient::Surrogate&, double y_m, double mark_z_m);

// Puts the left and right eye's frames side by side.
FilmFrame sideBySide(const FilmFrame& left, const FilmFrame& right);

// Number of frames per row, for a sheet of about screen proportions with as few empty places as possible.
int sheetColumns(int frames, int width, int height);

// Writes NAME-000.png ... and a sheet NAME.png with all frames at full size. Throws DataError.
void writeFilm(const std::vector<FilmFrame>&, const std::string& title, const std::filesystem::path& folder,
               const std::string& name);

}  // namespace stylet::report
