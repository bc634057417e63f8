// Reads the scenario's fields "controllers" (devices held and worn) and "hands" (bare hands for
// XR_EXT_hand_tracking).
#pragma once

#include "scenario/scenario.h"

namespace xrmock {

// A scenario describes all devices: a hand that it omits holds nothing. A control message replaces only the
// future keys of the fields it names. Both throw FieldError.
void readControllers(const Field& field, const ReadContext& context, Scenario& scenario);
void readHands(const Field& field, const ReadContext& context, Scenario& scenario);

}  // namespace xrmock
