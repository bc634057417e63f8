// The origin of a package as text for people. Programs read Package::atlases instead.
#pragma once

#include <string>
#include <vector>

#include "patient/package/package.h"

namespace stylet::patient {

// Returns `atlases: "A", "B"`. Empty if there are none. Control characters of the names, which come from
// files, become spaces.
std::string formatAtlasList(const std::vector<std::string>& names);

// The package's provenance, followed by its atlases if there are any.
std::string describeOrigin(const Package&);

}  // namespace stylet::patient
