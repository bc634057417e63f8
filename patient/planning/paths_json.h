// Internal: parses the text of paths.json.
#pragma once

#include <string_view>

#include "patient/planning/planning.h"

namespace stylet::patient {

// `file` is used in error messages only. Throws DataError.
StoredPaths parsePaths(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet::patient
