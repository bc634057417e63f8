// Places patient and operator in the room, and generates the head motion for the mock runtime. The operator
// stands at the patient's right side.
#pragma once

#include "patient/patient.h"

namespace stylet::trainer {

inline constexpr double kTableHeight_m = 0.95;

// View angles of the mock headset's eyes: left, right, up, down. As in real headsets they are wider toward
// the temples than toward the nose. The field of view is narrow, so that 640 pixels show enough detail.
inline constexpr double kMockEyeAngles_rad[2][4] = {{-0.62, 0.50, 0.50, -0.62}, {-0.50, 0.62, 0.50, -0.62}};
inline constexpr double kMockEyeDistance_m = 0.063;

// The patient lies supine (front up, head to the operator's left) with the back on the table and the path's
// entry in front of the operator. The operator stands at the stage's origin and looks along -z.
Pose stageFromPatient(const patient::Patient&, const patient::PlannedPath&);

// Point on the skin of the right flank at the middle of the liver's height. Depends on no path.
Vec3 flankMiddle(const patient::Patient&);

// Pose of upright eyes that look at a point of the stage.
Pose stageFromEyes(const Vec3& eyes_m, const Vec3& gaze_m);

// Head pose at `t_s`. The head leans over the entry, so that needle, flank and the inside of the liver are in
// view. It always sways a little.
Pose stageFromHead(const Pose& stage_from_patient, const patient::PlannedPath&, double t_s);

}  // namespace stylet::trainer
