// Reads the manifest of an OpenXR runtime, as the loader does.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace stylet::trainer {

// Path of the library in the manifest. Empty if it contains none or is not a manifest.
std::string readLibraryPath(std::string_view manifest);
// Same for a file; also empty if the file cannot be read.
std::string readLibraryPath(const std::filesystem::path& manifest);

}  // namespace stylet::trainer
