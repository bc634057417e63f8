// Reads the manifest of an OpenXR runtime, as the loader does.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace stylet::trainer {

// Path of the library that the manifest names; empty if it names none or is not a manifest.
std::string libraryNamedBy(std::string_view manifest);
// Same for a file; also empty if the file cannot be read.
std::string libraryNamedBy(const std::filesystem::path& manifest);

}  // namespace stylet::trainer
