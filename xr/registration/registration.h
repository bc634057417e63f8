// Registration: where the haptic device stands in the headset's room. Contains only the mathematics and the
// logic of the wizard. Needs neither an OpenXR runtime nor a device.
#pragma once

// In order of use.
// clang-format off
#include "xr/registration/geometry.h"  // points, rigid transforms, results
#include "xr/registration/rigid.h"     // Umeyama's fit, Fitzpatrick's error at a target
#include "xr/registration/pivot.h"     // the controller's tip
#include "xr/registration/fit.h"       // robust fit of all unknowns; verdict
#include "xr/registration/clock.h"     // pose streams: clock offset, pairs
#include "xr/registration/places.h"    // where to touch
#include "xr/registration/wizard.h"    // guides the user through the registration
#include "xr/registration/drift.h"     // is a registration still valid?
