// How breathing moves the patient: two stationary velocity fields on a coarse grid, driven by a surrogate.
// Based on Wilms et al. 2014 (fields regressed on the surrogate and its rate), Arsigny et al. 2006 (motion
// as the exponential of a field) and Schmidt-Richberg et al. 2012 (organs slide along the cavity's wall).
//
//   w(x,t) = a1(x) (v - v_ref) + a2(x) (v' - v'_ref)
//   outside the cavity   deformed = exp(wall)(reference)
//   inside               deformed = exp(wall)(exp(slide)(reference))
//
// `wall` is one field for the whole patient (ribs, abdominal wall, the interface with them). `slide` is
// tangential to the cavity's surface in the reference and maps that surface onto itself. So both sides
// move the interface to the same place at any amplitude. Two separate exponentials of fields with equal
// normal components would drift apart.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/geometry.h"
#include "patient/motion/signal.h"

namespace stylet::patient {

using Mat3 = glm::dmat3;

// a1 and a2 of one field at one node.
struct MotionCoefficients {
    std::array<float, 3> a1_m{};    // per unit of v
    std::array<float, 3> a2_m_s{};  // per unit of v'
    friend bool operator==(const MotionCoefficients&, const MotionCoefficients&) = default;
};

struct SurrogateRange {
    double low = 0.0, high = 0.0;
    friend bool operator==(const SurrogateRange&, const SurrogateRange&) = default;
};

// Fields and level on the nodes of a grid, x-fastest, linear between nodes. Outside the grid nothing moves
// and the level is that of the nearest border point. Both fields are zero on the outermost nodes. Without
// nodes the patient does not breathe.
struct MotionModel {
    Grid grid;
    std::vector<MotionCoefficients> wall, slide;
    std::vector<float> level_m;  // signed distance to the cavity's surface in the reference, < 0 inside
    Surrogate reference;         // the breathing state in which the CT was taken
    // range that the fields were fitted on; the current v and v' are clamped to it
    SurrogateRange v{-0.25, 1.5};
    SurrogateRange rate_per_s{-4.0, 4.0};
    // travel of the diaphragm's dome over v = 0..1; converts quantities given in millimetres
    double dome_travel_m = 0.015;

    bool empty() const noexcept { return level_m.empty(); }
    friend bool operator==(const MotionModel&, const MotionModel&) = default;
};

inline constexpr int kFlowSteps = 4;  // midpoint steps per exponential

// Largest difference [m] between the motions of two nodes in x, y or z, over all breathing states.
double maxNodeDifference(const MotionModel&, const MotionCoefficients&, const MotionCoefficients&) noexcept;
// Upper limit of maxNodeDifference() for neighbours, per metre between them. The integration steps cannot
// follow a steeper field, so packages with one are rejected.
inline constexpr double kMaxFieldGradient = 2.5;

// Any thread. noexcept, no allocation. A point outside the cavity costs half as much as one inside.
Vec3 deformedFromReference(const MotionModel&, const Surrogate& now, const Vec3& reference_m) noexcept;
// Inverts the wall field, then the slide field if the result lies inside the cavity.
Vec3 referenceFromDeformed(const MotionModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;
// Jacobian of deformedFromReference. The fields are linear between nodes, so it jumps between cells.
Mat3 motionJacobian(const MotionModel&, const Surrogate& now, const Vec3& reference_m) noexcept;
// Time derivative of deformedFromReference at a fixed point of the tissue. `acceleration_per_s2` is v''. A
// clamped component of the surrogate has zero rate.
Vec3 motionVelocity_m_s(const MotionModel&, const Surrogate& now, double acceleration_per_s2,
                        const Vec3& reference_m) noexcept;

// The same for a point whose side is known. A point in a gap or an overlap between the sides (fractions of
// a millimetre) would change sides on a round trip, so store the side together with the point.
enum class Side : std::uint8_t { outside, inside };
Side sideAt(const MotionModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;
Vec3 deformedFromReference(const MotionModel&, const Surrogate& now, Side, const Vec3& reference_m) noexcept;
Vec3 referenceFromDeformed(const MotionModel&, const Surrogate& now, Side, const Vec3& deformed_m) noexcept;

// First-order approximation of the motion around one tissue point and one breathing state. Code that
// follows a point from tick to tick uses it to evaluate the fields only after larger changes.
struct LocalMotion {
    bool known = false;
    Side side = Side::outside;
    Vec3 reference_m{0.0}, deformed_m{0.0};
    Mat3 deformed_from_reference{1.0}, reference_from_deformed{1.0};  // Jacobians
    // relative to the breathing state of the CT
    double v = 0.0, rate_per_s = 0.0;
    Vec3 by_v_m{0.0}, by_rate_m_s{0.0};
    double level_m = 1.0;  // level of the cavity's surface at the point where sideAt() evaluates it
};
// Range of validity of a LocalMotion: distance from its point, and displacement by breathing since.
struct LocalReach {
    double tissue_m = 1e-4, breath_m = 3e-4;
};
// Same as deformedFromReference, within micrometres. If the point or the breathing state is out of range, it
// recomputes `cached`, which costs twice as much as deformedFromReference. Otherwise it costs a twentieth.
Vec3 follow(LocalMotion& cached, const MotionModel&, const Surrogate& now, Side, const Vec3& reference_m,
            const LocalReach& = {}) noexcept;

// The field w itself at a point, in metres per unit time of its flow. Used to build tables of the motion.
enum class MotionPart { wall, slide };
Vec3 motionField_m(const MotionModel&, MotionPart, const Surrogate& now, const Vec3& p) noexcept;

// Signed distance to the cavity's surface, < 0 inside. The second overload is for a point of the deformed
// patient. Positive without nodes.
double cavityLevel_m(const MotionModel&, const Vec3& reference_m) noexcept;
double cavityLevel_m(const MotionModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;

// A crossing of the interface by a straight path through the deformed patient. `before` is the last share of
// the path on one side, `after` the first on the other side; they are at most 10 nm apart. The reference
// position jumps there, because the sides have slid past each other. The tissue in between is not on the
// path.
struct SideChange {
    double before = 0.0, after = 0.0;
};
inline constexpr int kMaxSideChanges = 16;  // further ones are ignored
struct SideChanges {
    Side first = Side::outside;  // side at the start of the path
    int count = 0;
    std::array<SideChange, kMaxSideChanges> list{};
};
// In order along the path. Empty if the motion is zero now.
SideChanges sideChanges(const MotionModel&, const Surrogate& now, const Vec3& from_m,
                        const Vec3& to_m) noexcept;

// Calls visit(begin, end) for each stretch of the path that lies on one side; arguments are shares of the
// path.
template <typename Visit>
void forEachStretch(const SideChanges& changes, const Visit& visit) {
    double begin = 0.0;
    for (int i = 0; i < changes.count; ++i) {
        visit(begin, changes.list[std::size_t(i)].before);
        begin = changes.list[std::size_t(i)].after;
    }
    visit(begin, 1.0);
}

}  // namespace stylet::patient
