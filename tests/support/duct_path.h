// A path to the middle of a duct. The duct begins 50 mm behind the skin and is 6 mm thick.
#pragma once

#include "patient/planning/planning.h"

namespace stylet::test {

// Along +x, from x = 0.
inline patient::PlannedPath ductPath() {
    patient::PlannedPath path;
    path.entry_m = path.entry_reference_m = {0.0, 0.0, 0.0};
    path.target_m = path.target_reference_m = {0.053, 0.0, 0.0};
    path.length_m = 0.053;
    return path;
}

}  // namespace stylet::test
