// Internal: reads and writes the text of patient.toml.
#pragma once

#include <string>
#include <string_view>

#include "patient/package/package.h"

namespace stylet::patient {

inline constexpr std::size_t kMaxTomlBytes = 1 << 20;

// Parses only [thresholds] and [[tissue]]; `file` is used in error messages only.
TissueDefaults parseTissueDefaults(const std::filesystem::path& file, std::string_view text);
// Parses everything in a package except its volumes. Throws DataError.
Package parsePackageToml(const std::filesystem::path& file, std::string_view text);
// The same package gives the same text. Doubles are written so that they read back bit-equal.
std::string packageToml(const Package&);

}  // namespace stylet::patient
