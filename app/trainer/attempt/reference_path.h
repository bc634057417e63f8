// The reference path: it guides the trainee, and the attempt is scored against it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/trainer/stores/start.h"
#include "app/training/progress.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// The best path for a guide wire: the first that meets the duct at 60 degrees or less, because the wire's tip
// sticks in the wall opposite if the path is steeper; else the path with the smallest angle. `paths`: at
// least one.
const patient::PlannedPath& pathForWire(const patient::Patient&,
                                        const std::vector<patient::PlannedPath>& paths);

// Returns the reference path at end-exhale, the breathing state of a commanded breath-hold. `asked`: empty
// for the patient's best path for this course; a number N for the N-th best path; otherwise the folder of an
// attempt on this patient, whose straight needle track from the skin to the target duct is used. Throws
// DataError if there are fewer paths, the attempt is on another patient, or its needle did not reach the
// target. `made` counts newly computed plans.
patient::PlannedPath referencePath(const patient::Patient&, const std::filesystem::path& patient_folder,
                                   const std::string& asked, training::Course, Made* made = nullptr);

}  // namespace stylet::trainer
