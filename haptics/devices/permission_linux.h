// Whether a device node may be used, and what to do when not.
#pragma once

#include <string>

namespace stylet::haptics {

// Empty when `node` may be read and written; else one line: what is wrong, and its remedy.
std::string accessProblem(const std::string& node);
// The same for an errno that opening it gave.
std::string accessProblem(const std::string& node, int error);

}  // namespace stylet::haptics
