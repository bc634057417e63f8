// An OpenXR runtime's manifest, as the loader reads it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace stylet::trainer {

// The library that it names; empty where it names none or is no manifest.
std::string libraryNamedBy(std::string_view manifest);
// The same of a file; empty too where it cannot be read.
std::string libraryNamedBy(const std::filesystem::path& manifest);

}  // namespace stylet::trainer
