// Patients whose pictures are known in closed form, or at least in outline.
#pragma once

#include "patient/displacement/tool_displacement.h"
#include "patient/patient.h"

namespace stylet::test {

// A ball of one tissue, centred in a cube of air with `margin_m` around it; the ball's centre is the
// patient's origin.
patient::Package makeBall(patient::Tissue, double radius_m, double margin_m, double spacing_m);

// A block that is one tissue to its faces; its middle is the patient's origin. Sizes are whole numbers of
// voxels.
patient::Package makeBlock(patient::Tissue, const Vec3& size_m, double spacing_m);

// A small trunk with everything the looks tell apart: skin, fat, ribs, spine, lung, liver with vessels and
// ducts. It breathes. About 32 x 22 x 24 cm, centred on the origin.
patient::Package makeTrunk(double spacing_m);

// Is a point of the deformed patient tissue?
bool inBody(const patient::Package&, const patient::Surrogate&, const Vec3& deformed_m);

// A ball of tissue at `skin_m` that a tool has taken along.
patient::ToolContact contactAt(const Vec3& skin_m, const Vec3& moved_m, double radius_m);

}  // namespace stylet::test
