// Internal: paths.json as text.
#pragma once

#include <string_view>
#include <vector>

#include "patient/planning.h"

namespace stylet::patient {

// `file` is only named in refusals. Throws DataError.
std::vector<PlannedPath> parsePaths(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet::patient
