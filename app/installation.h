// Locations of the running program and its assets, built or installed.
#pragma once

#include <filesystem>

namespace stylet {

// File and folder of the running program.
std::filesystem::path programFile();
std::filesystem::path programFolder();

// $STYLET_ASSETS, or the assets folder of the installation or source tree that contains the program. Throws
// DataError if there is none.
std::filesystem::path assetsFolder();

}  // namespace stylet
