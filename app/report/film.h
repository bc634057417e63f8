// Films of the breathing patient: coronal slices in one breath after the other, and sheets of all pictures.
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

// A coronal slice as a radiologist hangs it, at most 0.6 mm a pixel: labels as tints, the surface at which
// the sides of the motion slide as a line, and a mark at the height `mark_z_m`.
FilmFrame coronalFrame(const patient::Patient&, const patient::Surrogate&, double y_m, double mark_z_m);

// Left and right eye beside each other.
FilmFrame besideEachOther(const FilmFrame& left, const FilmFrame& right);

// How many frames in a row: a sheet about as wide as a screen, with as little left empty as can be.
int sheetColumns(int frames, int width, int height);

// NAME-000.png ... and NAME.png with all of them at full size. Throws patient::DataError.
void writeFilm(const std::vector<FilmFrame>&, const std::string& title, const std::filesystem::path& folder,
               const std::string& name);

}  // namespace stylet::report
