// Places patient and operator in the room, and generates the head motion for the mock runtime. The operator
// stands at the patient's right side.
#pragma once

#include "app/training/difficulty.h"
#include "patient/patient.h"

namespace stylet::trainer {

inline constexpr double kTableHeight_m = 0.95;

// View angles of the mock headset's eyes: left, right, up, down. As in real headsets they are wider toward
// the temples than toward the nose. The field of view is narrow, so that 640 pixels show enough detail.
inline constexpr double kMockEyeAngles_rad[2][4] = {{-0.62, 0.50, 0.50, -0.62}, {-0.50, 0.62, 0.50, -0.62}};
inline constexpr double kMockEyeDistance_m = 0.063;

// The part of the patient that the room is arranged around: table, operator, drape, lamp and C-arm. Points of
// the patient frame.
struct OperativeField {
    Vec3 entry_m;            // on the skin, in front of the operator
    Vec3 inside_m;           // beneath it; the operator looks at the line from the entry to this point
    Vec3 entry_reference_m;  // the entry in the patient that does not breathe: where the drape opens
    Vec3 isocentre_m;        // of the C-arm, until it is moved over the needle
};

// Where the C-arm is centred for a target: one picture shows the target and the hilum and little outside the
// patient.
Vec3 isocentreFor(const Vec3& target_m) noexcept;

// The field of a planned path.
OperativeField fieldOf(const patient::PlannedPath&) noexcept;

// A field that depends on no path: the right flank at the middle of the liver's height, and the liver's
// middle.
OperativeField flankField(const patient::Patient&);

// The field of the path, if the difficulty may show where that path enters; otherwise the flank's.
OperativeField operativeField(const patient::Patient&, const patient::PlannedPath&,
                              const training::DifficultyRules&);

// The patient lies supine (front up, head to the operator's left) with the back on the table and the field's
// entry in front of the operator. The operator stands at the stage's origin and looks along -z.
Pose stageFromPatient(const patient::Patient&, const OperativeField&);

// Pose of upright eyes that look at a point of the stage.
Pose stageFromEyes(const Vec3& eyes_m, const Vec3& gaze_m);

// Head pose at `t_s`. The head leans over the entry, so that needle, flank and the inside of the liver are in
// view. It always sways a little.
Pose stageFromHead(const Pose& stage_from_patient, const OperativeField&, double t_s);

}  // namespace stylet::trainer
