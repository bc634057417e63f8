// Checks the permissions of a device node and suggests a remedy.
#pragma once

#include <string>

namespace stylet::haptics {

// Returns empty if `node` can be read and written, else one line: the problem and its remedy.
std::string accessProblem(const std::string& node);
// The same for an errno from opening it.
std::string accessProblem(const std::string& node, int error);

}  // namespace stylet::haptics
