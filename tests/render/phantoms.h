// Patients whose pictures are known in closed form, or at least in outline.
#pragma once

#include "patient/displacement/tool_displacement.h"
#include "patient/patient.h"

namespace stylet::test {

// A package without tissue, centred on the origin.
patient::Package emptyPackage(const Vec3& half_m, double spacing_m);

// A ball of one tissue in a cube of air with `margin_m` around it. The ball's centre is the patient's
// origin.
patient::Package makeBall(patient::Tissue, double radius_m, double margin_m, double spacing_m);

// A block that is filled with one tissue up to its faces. Its centre is the patient's origin. Sizes are
// whole numbers of voxels.
patient::Package makeBlock(patient::Tissue, const Vec3& size_m, double spacing_m);

// A small trunk with every structure that the looks distinguish: skin, fat, ribs, spine, lung, and liver
// with vessels and ducts. It breathes. About 32 x 22 x 24 cm, centred on the origin.
patient::Package makeTrunk(double spacing_m);

// True if a point of the deformed patient lies in tissue.
bool inBody(const patient::Package&, const patient::Surrogate&, const Vec3& deformed_m);

// A contact in which a tool has moved a ball of tissue at `skin_m`.
patient::ToolContact contactAt(const Vec3& skin_m, const Vec3& moved_m, double radius_m);

}  // namespace stylet::test
