// The reference path: it guides the trainee, and the attempt is scored against it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/trainer/stores/start.h"
#include "app/training/progress.h"
#include "patient/contrast/duct_space.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// How far a guide wire goes down the duct from a needle at the path's target, up to kWireReach_m; pushed by
// the model of haptics/tools/wire.h.
inline constexpr double kWireReach_m = 0.035;
double wireReach_m(const patient::DuctSpace&, const patient::PlannedPath&);
// The worst case of wireReach_m() if the needle's tip comes to lie at the target, or 1 mm beside or behind
// it.
inline constexpr double kSureReach_m = 0.025;
double sureWireReach_m(const patient::DuctSpace&, const patient::PlannedPath&);
// The best path for a drainage: the first from which the wire goes kWireReach_m down the duct, and
// kSureReach_m in the worst case. If there is none: among those from which it goes kWireReach_m the one with
// the best worst case, else the one from which it goes furthest. `paths`: at least one.
const patient::PlannedPath& pathForWire(const patient::DuctSpace&,
                                        const std::vector<patient::PlannedPath>& paths);

// Returns the reference path at end-exhale, the breathing state of a commanded breath-hold. `asked`: empty
// for the patient's best path for this course; a number N for the N-th best path; otherwise the folder of an
// attempt on this patient, whose straight needle track from the skin to the target duct is used. Throws
// DataError if there are fewer paths, the attempt is on another patient, or its needle did not reach the
// target. `made` counts newly computed plans.
patient::PlannedPath referencePath(const patient::Patient&, const std::filesystem::path& patient_folder,
                                   const std::string& asked, training::Course, Made* made = nullptr);

}  // namespace stylet::trainer
