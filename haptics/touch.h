// What a hand meets at the skin: how deep a point is, how stiffly the layers under it resist, how thick they
// lie on bone. Hashed: double precision, no libm transcendental. After Fortmeier, Mastmeyer and Handels, "An
// Image-Based Multiproxy Palpation Algorithm for Patient-Specific VR-Simulation", MMVR 2014; the layers as
// springs in series are the model's (section 3).
#pragma once

#include <limits>
#include <vector>

#include "haptics/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

using patient::Mat3;
using patient::Pose;
using patient::Vec3;

inline constexpr double kTouchDepth_m = 0.040;  // the layers that yield, from the skin
inline constexpr double kDeepestTip_m = 0.050;  // that a tool's tip is taken to be under its skin

// The layers under a point of the skin, exactly, voxel by voxel.
struct Layers {
    double compliance_m_per_pa = 0.0;  // sum h/E down to kTouchDepth_m or to bone, which is rigid and ends it
    double cover_m = std::numeric_limits<double>::infinity();  // their thickness over bone
};
// `inward` is a unit vector; `skin_m` may lie up to 2 mm off the skin. Outer air in front does not count, and
// where the image ends the last tissue goes on.
Layers layersUnder(const patient::Patient&, const Vec3& skin_m, const Vec3& inward) noexcept;

// The same for every point near the skin: node values of a quadratic B-spline on the skin's own nodes. Inside
// the body a node holds the layers under its foot on the skin. So pressing and sliding have one potential,
// which is smooth, and a look-up costs the same over one layer or ten.
struct TouchMap {
    patient::Grid grid;
    std::vector<float> nodes;  // level_m, stiffness_n_per_m3, bone_per_m of each node, x-fastest
};
// At load: 0.6 s on one thread for 15 million voxels. The thread count does not change the result.
TouchMap makeTouchMap(const patient::Patient&, const patient::Skin&, int threads);
TouchMap makeTouchMap(const patient::Patient&);  // of its own skin, on two threads

struct TouchPoint {
    double level_m = 0.0;             // < 0 in the body
    double stiffness_n_per_m3 = 0.0;  // 1 / compliance: pressure per depth, at first
    double bone_per_m = 0.0;          // 1 / cover; 0 where no bone is within kTouchDepth_m
    Vec3 level_slope{0.0}, stiffness_slope{0.0}, bone_slope{0.0};  // gradients
};
// Haptics thread. noexcept, no allocation, about 0.1 us.
TouchPoint touchAt(const TouchMap&, const Vec3& reference_m) noexcept STYLET_NONBLOCKING;

// Layers on bone cannot be pressed to nothing: they stiffen with the strain e = depth / cover, as 1/(1 - e)^3
// (energy k d^2 / 2 (1 - e)), until half of them is left; then it is bone that gives way, with `stiffest`.
// That bounds every tangent; layers so thin that they would exceed it begin at an eighth of it.
inline constexpr double kMostStrain = 0.5, kMostStiffening = 8.0;

// What pressing a point costs per area, and what it pushes with.
struct Pressed {
    double energy_j_per_m2 = 0.0;
    double pressure_pa = 0.0;  // slope of the energy over the depth
    Vec3 push_n_per_m2{0.0};   // minus its gradient: outward, and away from what is stiffer
};
// Haptics thread. noexcept, no allocation.
Pressed pressed(const TouchPoint&, double stiffest_n_per_m3) noexcept STYLET_NONBLOCKING;

// The breath around a point, as far as a tool reaches: p_reference = at_reference_m + slope * (p - at_m).
struct Carried {
    Vec3 at_m{0.0}, at_reference_m{0.0};
    Mat3 slope{1.0};
    Vec3 operator()(const Vec3& deformed_m) const noexcept {
        return at_reference_m + slope * (deformed_m - at_m);
    }
};
// How far the breath has moved a point of the skin since `then`. Haptics thread.
Vec3 skinMoved(const patient::MotionModel&, const patient::Surrogate& then, const patient::Surrogate& now,
               const Vec3& skin_reference_m) noexcept STYLET_NONBLOCKING;
// Haptics thread, both. noexcept, no allocation. The second finds the slope, by secants of 6 mm along the
// axes of `frame` (a rotation), the last of which should point out of the body: organs slide on their own.
Carried carriedAt(const patient::MotionModel&, const patient::Surrogate&,
                  const Vec3& deformed_m) noexcept STYLET_NONBLOCKING;
void addSlope(Carried&, const patient::MotionModel&, const patient::Surrogate&,
              const Mat3& frame) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
