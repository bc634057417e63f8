// Where everybody is: the patient on the table, the operator at his right side, and how the mock runtime's
// head moves.
#pragma once

#include <filesystem>

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

// A head pose at t_s: leaning over the entry, needle, flank and the inside of the liver in view, never quite
// still.
patient::Pose stageFromHead(const patient::Pose& stage_from_patient, const patient::PlannedPath&, double t_s);

// The mock runtime's scenario (xr/mock/README.md): that head for two minutes, 640 x 640 an eye.
void writeHeadScript(const std::filesystem::path& file, const patient::Pose& stage_from_patient,
                     const patient::PlannedPath&);

// True when the runtime that the loader would take now is the mock runtime.
bool mockRuntimeChosen();

// Tells the mock runtime, which reads its environment when an instance is made. An empty capture folder: no
// pictures.
void setUpMock(const std::filesystem::path& head_script, bool virtual_clock,
               const std::filesystem::path& capture_dir);

}  // namespace stylet::trainer
