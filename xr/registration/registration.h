// Where the haptic device stands in the headset's room. Mathematics and a wizard's logic; no runtime, no
// device.
#pragma once

// In order of use.
// clang-format off
#include "xr/registration/geometry.h"  // points, rigid transforms, answers
#include "xr/registration/rigid.h"     // Umeyama's fit, Fitzpatrick's error at a target
#include "xr/registration/pivot.h"     // the controller's tip
#include "xr/registration/fit.h"       // everything at once, robustly; accept or redo
#include "xr/registration/clock.h"     // streams in motion: clock offset, pairs
#include "xr/registration/places.h"    // where to touch
#include "xr/registration/wizard.h"    // what a user is told and what he answers
#include "xr/registration/drift.h"     // does it still hold
