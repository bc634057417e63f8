// Plausibility checks of a patient package, and the defects that make it impossible to simulate.
#pragma once

#include <string>
#include <vector>

#include "patient/package/package.h"

namespace stylet::modeller {

struct Finding {
    bool refused = false;  // must not be used for training or a study; false: should be inspected
    std::string what;      // "liver volume"
    std::string value;     // "245 ml"
    std::string expected;  // "600 to 3500 ml"
    std::string reason;    // the reason for the expected range, with its source
};

// Refuses packages without skin, liver, fascia or lungs; a fascia that a straight needle can bypass; CT
// values that do not match their tissue; a motion that folds; missing parameters or labels; a section that
// cuts the liver or leaves no air for the needle; what check_scan.h finds: lost vessels, a cut flank, a
// fascia outside the body, bone at the liver, ducts in fat. Warns, among others, of bone inside the liver.
// Takes seconds, because it plans paths. A plausible patient gives no findings. The package need not come
// from a file. The same package always gives the same findings.
std::vector<Finding> checkPackage(const patient::Package&, int threads = 2);

bool anyRefused(const std::vector<Finding>&);

// "REFUSED  liver volume: 245 ml, expected 600 to 3500 ml (...)".
std::string formatFinding(const Finding&);

}  // namespace stylet::modeller
