// What is implausible in a patient package, and what keeps it from being simulated at all.
#pragma once

#include <string>
#include <vector>

#include "patient/package.h"

namespace stylet::modeller {

struct Finding {
    bool refused = false;  // cannot be simulated; else it can, but look at it
    std::string what;      // "liver volume"
    std::string value;     // "245 ml"
    std::string expected;  // "600 to 3500 ml"
    std::string reason;    // why that is expected, with its source
};

// Refused are packages without skin, liver, fascia or lungs, with a fascia that a straight needle passes
// through, values that are not of their tissue, a motion that folds, parameters or labels that are missing,
// and a section that cuts the liver or leaves the needle no air. Paths are planned, so it takes seconds.
// Nothing is found in a plausible patient. The package need not come from a file; same package, same
// findings.
std::vector<Finding> checkPackage(const patient::Package&, int threads = 2);

bool anyRefused(const std::vector<Finding>&);

// "REFUSED  liver volume: 245 ml, expected 600 to 3500 ml (...)".
std::string lineOf(const Finding&);

}  // namespace stylet::modeller
