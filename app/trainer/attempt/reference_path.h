// The reference path: it guides the trainee, and the attempt is scored against it.
#pragma once

#include <filesystem>
#include <string>

#include "app/trainer/stores/start.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// Returns the reference path at end-exhale, the breathing state of a commanded breath-hold. `asked`: empty
// for the patient's best path; a number N for the N-th best path; otherwise the folder of an attempt on this
// patient, whose straight needle track from the skin to the target duct is used. Throws DataError if there
// are fewer paths, the attempt is on another patient, or its needle did not reach the target. `made` counts
// newly computed plans.
patient::PlannedPath referencePath(const patient::Patient&, const std::filesystem::path& patient_folder,
                                   const std::string& asked, Made* made = nullptr);

}  // namespace stylet::trainer
