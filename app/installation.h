// Locations of the running program and its assets, built or installed.
#pragma once

#include <filesystem>
#include <string>

namespace stylet {

// File and folder of the running program.
std::filesystem::path programFile();
std::filesystem::path programFolder();

// $STYLET_ASSETS, or the assets folder of the installation or source tree that contains the program. Throws
// DataError if there is none, or if the variable names another folder.
std::filesystem::path assetsFolder();

// Returns `name` if it ends with .toml, else the file NAME.toml in the assets folder KINDs ("look": looks/).
// Throws DataError with the names in that folder.
std::filesystem::path assetFile(const std::string& kind, const std::string& name);

}  // namespace stylet
