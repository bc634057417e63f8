// Internal: patient.toml as text, both ways.
#pragma once

#include <string>
#include <string_view>

#include "patient/package.h"

namespace stylet::patient {

inline constexpr std::size_t kMaxTomlBytes = 1 << 20;

// [thresholds] and [[tissue]] alone; `file` is only named in refusals.
TissueDefaults parseTissueDefaults(const std::filesystem::path& file, std::string_view text);
// Everything of a package but its volumes. Throws DataError.
Package parsePackageToml(const std::filesystem::path& file, std::string_view text);
// Same package, same text; doubles are written so that they read back bit-equal.
std::string packageToml(const Package&);

}  // namespace stylet::patient
