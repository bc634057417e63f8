// The lumen of the target ducts as a signed distance. A guide wire stays inside it. Computed once per
// patient.
#pragma once

#include "base/realtime.h"
#include "patient/package/package.h"

namespace stylet::patient {

// Distance to the wall, and the direction out of the lumen (unit vector; zero where it is undetermined).
struct DuctWall {
    double level_m = 0.0;  // < 0 in the lumen
    Vec3 outward{0.0};
};

struct DuctSpace {
    // Of voxel centres in the reference frame, in a box around all ducts of the target role. No voxels: the
    // patient has no such duct. The wall lies half a voxel beyond the labelled voxels.
    Volume<float> level_m;
};

inline constexpr double kFarFromDucts_m = 0.004;  // level beyond the box, which has this margin

// The result does not depend on the thread count or the compiler.
DuctSpace makeDuctSpace(const Patient&, int threads = 2);

// Haptics thread. noexcept, no allocation, about 0.05 us. Trilinear between voxel centres; kFarFromDucts_m
// outside the box and for NaN.
DuctWall ductWallAt(const DuctSpace&, const Vec3& reference_m) noexcept STYLET_NONBLOCKING;
// Only the level of ductWallAt(), which costs less.
double ductLevelAt(const DuctSpace&, const Vec3& reference_m) noexcept STYLET_NONBLOCKING;
// True in the lumen of a target duct.
inline bool isInTargetDuct(const DuctSpace& ducts, const Vec3& reference_m) noexcept {
    return ductLevelAt(ducts, reference_m) < 0.0;
}

}  // namespace stylet::patient
