// The hands' part of the scenario: "controllers" (what is held and worn) and "hands" (the bare hands that
// XR_EXT_hand_tracking sees).
#pragma once

#include "scenario.h"

namespace xrmock {

// A scenario says everything that there is; what a control message names gives up what was to come. Both
// throw FieldError.
void readControllers(const Field& field, const Reading& reading, Scenario& scenario);
void readHands(const Field& field, const Reading& reading, Scenario& scenario);

}  // namespace xrmock
