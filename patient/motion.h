// How the breath moves the patient: two stationary velocity fields on a coarse grid, driven by a surrogate.
// Based on Wilms et al. 2014 (fields regressed on the surrogate and its rate), Arsigny et al. 2006 (motion as
// the exponential of a field) and Schmidt-Richberg et al. 2012 (organs slide along the cavity's wall).
//
//   w(x,t) = a1(x) (v - v_ref) + a2(x) (v' - v'_ref)
//   outside the cavity   deformed = exp(wall)(reference)
//   inside               deformed = exp(wall)(exp(slide)(reference))
//
// `wall` is one field everywhere (ribs, abdominal wall, the interface with them); `slide` is tangential at
// the cavity's surface of the reference and keeps it in place. So both sides take the interface to the same
// place, whatever the amplitude; two exponentials of fields with equal normal parts would drift apart.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patient/geometry.h"
#include "patient/signal.h"

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

// Node values, x-fastest, linear between nodes. Beyond the grid nothing moves, and the level of its border
// holds; both fields are zero on the outermost nodes. No nodes: the patient does not breathe.
struct MotionModel {
    Grid grid;
    std::vector<MotionCoefficients> wall, slide;
    std::vector<float> level_m;    // distance to the cavity's surface in the reference, < 0 inside
    Surrogate reference;           // the breath in which the CT was taken
    SurrogateRange v{-0.25, 1.5};  // what the fields were fitted on; now's v and v' are clamped to it
    SurrogateRange rate_per_s{-4.0, 4.0};
    double dome_travel_m = 0.015;  // of the diaphragm's dome over v = 0..1, for what is told in millimetres

    bool empty() const noexcept { return level_m.empty(); }
    friend bool operator==(const MotionModel&, const MotionModel&) = default;
};

inline constexpr int kFlowSteps = 4;  // midpoint steps of each exponential

// The most by which two nodes' motions differ in any breath, along one axis of space; metres.
double widestChange(const MotionModel&, const MotionCoefficients&, const MotionCoefficients&) noexcept;
// Of neighbours, per metre between them: the flow's steps follow no steeper field, and no package holds one.
inline constexpr double kSteepestField = 2.5;

// Any thread. noexcept, no allocation; at a point outside the cavity half of an inside point's cost.
Vec3 deformedFromReference(const MotionModel&, const Surrogate& now, const Vec3& reference_m) noexcept;
// Takes the wall's field back, then, where that ends inside the cavity, the slide.
Vec3 referenceFromDeformed(const MotionModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;
// Of deformedFromReference. Linear between nodes, so it jumps from cell to cell.
Mat3 motionJacobian(const MotionModel&, const Surrogate& now, const Vec3& reference_m) noexcept;
// d/dt of deformedFromReference at a fixed point of the tissue; `acceleration_per_s2` is v''. A clamped part
// of the surrogate stands still.
Vec3 motionVelocity_m_s(const MotionModel&, const Surrogate& now, double acceleration_per_s2,
                        const Vec3& reference_m) noexcept;

// The same for a point that is known to lie on this side. What lies within a gap or an overlap of the sides
// (fractions of a millimetre) changes sides on its way there and back: whoever keeps such a point keeps its
// side beside it.
enum class Side : std::uint8_t { outside, inside };
Side sideOf(const MotionModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;
Vec3 deformedFromReference(const MotionModel&, const Surrogate& now, Side, const Vec3& reference_m) noexcept;
Vec3 referenceFromDeformed(const MotionModel&, const Surrogate& now, Side, const Vec3& deformed_m) noexcept;

// The motion about one point of the tissue and one breath, to first order: what follows a point from tick to
// tick asks the fields anew only where either has changed by much.
struct LocalMotion {
    bool known = false;
    Side side = Side::outside;
    Vec3 reference_m{0.0}, deformed_m{0.0};
    Mat3 deformed_from_reference{1.0}, reference_from_deformed{1.0};  // slopes
    double v = 0.0, rate_per_s = 0.0;                                 // against the breath of the CT
    Vec3 by_v_m{0.0}, by_rate_m_s{0.0};
    double level_m = 1.0;  // of the cavity's surface, where sideOf() looks
};
// How far the point may be from the one known, and the breath have carried it since.
struct LocalReach {
    double tissue_m = 1e-4, breath_m = 3e-4;
};
// As deformedFromReference, within micrometres. Makes `about` anew where the point or the breath is out of
// its reach: twice the cost of deformedFromReference, else a twentieth.
Vec3 follow(LocalMotion& about, const MotionModel&, const Surrogate& now, Side, const Vec3& reference_m,
            const LocalReach& = {}) noexcept;

// w itself at a point, metres per unit time of its flow: what a table of the motion is made from.
enum class MotionPart { wall, slide };
Vec3 motionField_m(const MotionModel&, MotionPart, const Surrogate& now, const Vec3& p) noexcept;

// Distance to the cavity's surface, < 0 inside; of a point of the deformed patient in the second form.
// Positive without nodes.
double cavityLevel_m(const MotionModel&, const Vec3& reference_m) noexcept;
double cavityLevel_m(const MotionModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;

// A straight way through the deformed patient changes sides here: the last share of it on the one side and
// the first on the other, at most 10 nm apart. Where the sides have slid past each other the reference jumps,
// and what lies between is not on the way.
struct SideChange {
    double before = 0.0, after = 0.0;
};
inline constexpr int kMaxSideChanges = 16;  // more are left out
struct SideChanges {
    Side first = Side::outside;  // where the way begins
    int count = 0;
    std::array<SideChange, kMaxSideChanges> list{};
};
// In order. No changes where nothing moves now.
SideChanges sideChanges(const MotionModel&, const Surrogate& now, const Vec3& from_m,
                        const Vec3& to_m) noexcept;

// visit(begin, end) for each stretch of the way on one side, as shares of it.
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
