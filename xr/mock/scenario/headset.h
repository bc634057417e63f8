// Headset descriptions as data: display and tracking properties. See headsets/*.json and SCENARIO.md.
#pragma once

#include <string>

#include "scenario/scenario.h"

namespace xrmock {

// Loads a headset file, or a built-in headset by name. Throws FieldError.
void loadHeadset(const std::string& name_or_file, Scenario& scenario);
// Reads the fields that a headset file shares with "eyes" in a scenario.
void readEyes(const Field& field, Scenario& scenario);

}  // namespace xrmock
