// A tool that points along +x of the patient.
#pragma once

#include "patient/patient.h"

namespace stylet::test {

// Its +z, toward the hub and out of the patient, is -x: layers begin at x = 0 and go on toward +x.
inline const Quat kAlongX{0.70710678118654752, 0.0, -0.70710678118654752, 0.0};

}  // namespace stylet::test
