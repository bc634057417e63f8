// Where the program and what belongs to it lie: built or installed.
#pragma once

#include <filesystem>

namespace stylet {

// File and folder of the running program.
std::filesystem::path programFile();
std::filesystem::path programFolder();

// $STYLET_ASSETS, or assets/ of the installation or source tree that the program lies in. Throws
// patient::DataError.
std::filesystem::path assetsFolder();

}  // namespace stylet
