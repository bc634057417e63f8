// Internal: paths.json as text.
#pragma once

#include <string_view>

#include "patient/planning.h"

namespace stylet::patient {

// `file` is only named in refusals. Throws DataError.
StoredPaths parsePaths(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet::patient
