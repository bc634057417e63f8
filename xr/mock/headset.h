// Headsets as data: what a display shows and what its sensors see. See headsets/*.json and SCENARIO.md.
#pragma once

#include <string>

#include "scenario.h"

namespace xrmock {

// A file, or the name of one that came with the library. Throws FieldError.
void loadHeadset(const std::string& name_or_file, Scenario& scenario);
// The fields that a headset file shares with the "eyes" of a scenario.
void readEyes(const Field& field, Scenario& scenario);

}  // namespace xrmock
