// Conversion of path strings to XrPath atoms and back, and the rules for well-formed paths (OpenXR 1.0,
// "Semantic Paths").
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/openxr_api.h"

namespace xrmock {

// Returns whether the text is a valid level of a path, or a valid name of an action or action set: only a-z
// 0-9 - _ . and not only dots.
bool isWellFormedLevel(std::string_view level);
bool isWellFormedPath(std::string_view path);

class PathTable {
  public:
    XrPath fromString(std::string_view path);        // the path must be well formed
    const std::string* toString(XrPath path) const;  // null for an atom never issued

  private:
    std::vector<std::string> strings_;
    std::map<std::string, XrPath, std::less<>> atoms_;
};

}  // namespace xrmock
