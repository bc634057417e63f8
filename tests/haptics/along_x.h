// A tool that points along +x of the patient.
#pragma once

#include "patient/patient.h"

namespace stylet::test {

// The tool's +z points toward the hub, out of the patient, and is the patient's -x. The layers of
// test::makeSlabs() start at x = 0 and continue toward +x.
inline const Quat kAlongX{0.70710678118654752, 0.0, -0.70710678118654752, 0.0};

}  // namespace stylet::test
