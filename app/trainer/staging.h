// Where everybody is: the patient on the table, the operator at his right side, and how the mock runtime's
// head moves.
#pragma once

#include "patient/patient.h"

namespace stylet::trainer {

inline constexpr double kTableHeight_m = 0.95;

// The mock headset's eyes: tangents' angles left, right, up, down, wider toward the temples than toward the
// nose as headsets have them; a narrow headset, so that 640 pixels show what matters.
inline constexpr double kMockEyeAngles_rad[2][4] = {{-0.62, 0.50, 0.50, -0.62}, {-0.50, 0.62, 0.50, -0.62}};
inline constexpr double kMockEyeDistance_m = 0.063;

// The patient supine (front up, head to the operator's left) with the back on the table and the path's entry
// before the operator, who stands at the stage's origin and looks along -z.
patient::Pose stageFromPatient(const patient::Patient&, const patient::PlannedPath&);

// Eyes that look at a point of the stage, upright.
patient::Pose stageFromEyes(const patient::Vec3& eyes_m, const patient::Vec3& gaze_m);

// A head pose at t_s: leaning over the entry, needle, flank and the inside of the liver in view, never quite
// still.
patient::Pose stageFromHead(const patient::Pose& stage_from_patient, const patient::PlannedPath&, double t_s);

}  // namespace stylet::trainer
