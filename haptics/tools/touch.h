// Contact with the skin: the depth of a point, the stiffness of the layers under it, and their thickness
// over bone. Its results enter the state hash, so it uses double precision and no libm transcendentals.
// After Fortmeier, Mastmeyer and Handels, "An Image-Based Multiproxy Palpation Algorithm for
// Patient-Specific VR-Simulation", MMVR 2014. The model (section 3) treats the layers as springs in series.
#pragma once

#include <limits>
#include <vector>

#include "base/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

using patient::Mat3;

inline constexpr double kTouchDepth_m = 0.040;  // depth of the compliant layers, from the skin
inline constexpr double kDeepestTip_m = 0.050;  // largest assumed depth of a tool's tip under the skin

// The layers under a point of the skin, computed exactly, voxel by voxel.
struct Layers {
    // Sum of h/E down to kTouchDepth_m, or to bone, which is rigid and ends the sum.
    double compliance_m_per_pa = 0.0;
    double cover_m = std::numeric_limits<double>::infinity();  // thickness of the layers over bone
};
// `inward` is a unit vector. `skin_m` may lie up to 2 mm off the skin. Air in front of the skin is ignored.
// Beyond the image's edge the last tissue continues.
Layers computeLayers(const patient::Patient&, const Vec3& skin_m, const Vec3& inward) noexcept;

// The layers for every point near the skin, as a quadratic B-spline on the skin's own nodes. A node inside
// the body stores the layers under its foot point on the skin. Pressing and sliding therefore share one
// smooth potential, and a look-up costs the same for any number of layers.
struct TouchMap {
    Grid grid;
    std::vector<float> nodes;  // level_m, stiffness_n_per_m3 and bone_per_m of each node, x-fastest
};
// Called at load time: 0.6 s on one thread for 15 million voxels. The result does not depend on the thread
// count.
TouchMap makeTouchMap(const patient::Patient&, const patient::Skin&, int threads);
TouchMap makeTouchMap(const patient::Patient&);  // builds the skin too, two threads

struct TouchPoint {
    double level_m = 0.0;             // signed distance to the skin, < 0 in the body
    double stiffness_n_per_m3 = 0.0;  // 1 / compliance: pressure per depth for small strains
    double bone_per_m = 0.0;          // 1 / cover; 0 where no bone is within kTouchDepth_m
    Vec3 level_slope{0.0}, stiffness_slope{0.0}, bone_slope{0.0};  // gradients
};
// Haptics thread. noexcept, no allocation, about 0.1 us.
TouchPoint touchAt(const TouchMap&, const Vec3& reference_m) noexcept STYLET_NONBLOCKING;

// Layers on bone cannot be compressed to zero. They stiffen with the strain e = depth / cover as 1/(1 - e)^3
// (energy k d^2 / 2 (1 - e)), until half their thickness is left. Beyond that, bone itself yields, with the
// stiffness `stiffest`. This bounds every tangent. If the layers are so thin that they would exceed it, their
// initial stiffness is an eighth of it.
inline constexpr double kMaxStrain = 0.5, kMaxStiffening = 8.0;

// Energy and force per area of pressing on a point.
struct SkinPressure {
    double energy_j_per_m2 = 0.0;
    double pressure_pa = 0.0;  // derivative of the energy with respect to depth
    Vec3 push_n_per_m2{0.0};   // minus the energy's gradient: outward, and away from stiffer places
};
// Haptics thread. noexcept, no allocation.
SkinPressure computePressure(const TouchPoint&, double stiffest_n_per_m3) noexcept STYLET_NONBLOCKING;

// The skin at one breathing state: what a tool touches in one tick. Stores references, so use it only within
// the tick.
struct BreathingSkin {
    const TouchMap& map;
    const patient::MotionModel& motion;
    const patient::Surrogate& breath;
};

// Linear map from the deformed to the reference frame, valid within a tool's reach of a point: p_reference =
// at_reference_m + slope * (p - at_m).
struct LocalBreathingMap {
    Vec3 at_m{0.0}, at_reference_m{0.0};
    Mat3 slope{1.0};
    Vec3 operator()(const Vec3& deformed_m) const noexcept {
        return at_reference_m + slope * (deformed_m - at_m);
    }
};

// All functions below: haptics thread. noexcept, no allocation.
// How far breathing has moved a skin point since the breathing state `then`.
Vec3 skinDisplacement(const BreathingSkin&, const patient::Surrogate& then,
                      const Vec3& skin_reference_m) noexcept STYLET_NONBLOCKING;
// breathingMapAt() sets the slope to identity; addSlope() computes it with secants of 6 mm along the axes of
// `frame` (a rotation). The last axis should point out of the body: a secant into the body could reach
// organs, which slide independently of the skin.
LocalBreathingMap breathingMapAt(const BreathingSkin&, const Vec3& deformed_m) noexcept STYLET_NONBLOCKING;
void addSlope(LocalBreathingMap&, const BreathingSkin&, const Mat3& frame) noexcept STYLET_NONBLOCKING;

// The unit vector along `v`, or `otherwise` if v is zero.
Vec3 unitOr(const Vec3& v, const Vec3& otherwise) noexcept STYLET_NONBLOCKING;
// A proxy on the skin sticks up to `most_m` from its point, then slips after it. Returns true if it slips.
// `stretch_m` is set to the spring's extension along the skin.
bool dragProxy(Vec3& proxy_m, const Vec3& point_m, const Vec3& normal, double most_m,
               Vec3& stretch_m) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
