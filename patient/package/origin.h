// The origin of a package as text for people. Programs read Package::atlases and synthVariants() instead.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "patient/package/package.h"

namespace stylet::patient {

// Returns `atlases: "A", "B"`. Empty if there are none. Control characters of the names, which come from
// files, become spaces.
std::string formatAtlasList(const std::vector<std::string>& names);

// The variants of a patient made by `stylet-model synth --variant`, such as "native,noise-x2", from its
// provenance. Empty without that option.
std::string_view synthVariants(std::string_view provenance);

// The package's provenance, followed by its atlases if there are any.
std::string describeOrigin(const Package&);

}  // namespace stylet::patient
