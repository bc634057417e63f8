// Based on Wilms et al. 2014 and Arsigny et al. 2006; see motion.h. Hashed: double precision, no libm
// transcendentals.
#include "patient/motion/motion.h"

#include <algorithm>
#include <cmath>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace stylet::patient {
namespace {

constexpr double kNear_m = 1e-8;  // accuracy of a change of sides
// upper bound of the level's gradient in the deformed patient, per metre
constexpr double kMaxLevelGradient = 2.0;
constexpr double kMinSideStep_m = 2e-4;
constexpr int kMaxSideSamples = 4096;

// The clamped surrogate relative to the breathing state of the CT.
struct Drive {
    double v = 0.0, rate = 0.0;
    bool isZero() const noexcept { return v == 0.0 && rate == 0.0; }
    Drive operator-() const noexcept { return {-v, -rate}; }
};

// Clamps to the range. NaN becomes the lower end.
double clampTo(const SurrogateRange& range, double x) noexcept {
    return x > range.low ? std::min(x, range.high) : range.low;
}

Drive makeDrive(const MotionModel& m, const Surrogate& now) noexcept {
    return {clampTo(m.v, now.v) - m.reference.v + (now.creep_v - m.reference.creep_v),
            clampTo(m.rate_per_s, now.rate_per_s) - m.reference.rate_per_s};
}

// Two components in one register; the compiler does not vectorise this by itself.
using Two = double __attribute__((vector_size(2 * sizeof(double))));

Two loadTwo(const float* from) noexcept {
#ifdef __SSE2__
    return Two(_mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from)))));
#else
    return Two{double(from[0]), double(from[1])};
#endif
}

// a1 and a2 of a point: (a1x, a1y), (a1z, a2x), (a2y, a2z).
struct CoefficientPair {
    Two part[3];

    static CoefficientPair at(const MotionCoefficients* node) noexcept {
        static_assert(sizeof(MotionCoefficients) == 6 * sizeof(float));
        const float* const c = node->a1_m.data();
        return {{loadTwo(c), loadTwo(c + 2), loadTwo(c + 4)}};
    }
    Vec3 evaluate(const Drive& d) const noexcept {
        return Vec3(part[0][0], part[0][1], part[1][0]) * d.v +
               Vec3(part[1][1], part[2][0], part[2][1]) * d.rate;
    }
};

CoefficientPair operator-(const CoefficientPair& a, const CoefficientPair& b) noexcept {
    return {{a.part[0] - b.part[0], a.part[1] - b.part[1], a.part[2] - b.part[2]}};
}
CoefficientPair along(const CoefficientPair& from, const CoefficientPair& delta, double share) noexcept {
    return {{from.part[0] + share * delta.part[0], from.part[1] + share * delta.part[1],
             from.part[2] + share * delta.part[2]}};
}
CoefficientPair between(const CoefficientPair& low, const CoefficientPair& high, double share) noexcept {
    return along(low, high - low, share);
}

// A small displacement that the flow carries along. A change of the drive adds to it (forward derivative).
struct Change {
    Vec3 moved_m{0.0};
    Drive drive{};
};

// One field with one drive.
class Flow {
  public:
    Flow(const MotionModel& m, const std::vector<MotionCoefficients>& field, const Drive& drive) noexcept
        : field_(field.data()),
          origin_m_(m.grid.origin_m),
          per_m_(1.0 / m.grid.spacing_m),
          last_(m.grid.dims - 1),
          row_(std::size_t(m.grid.dims.x)),
          slice_(row_ * std::size_t(m.grid.dims.y)),
          drive_(drive) {}

    // exp of the field over unit time.
    Vec3 carry(Vec3 p) const noexcept {
        constexpr double kStep = 1.0 / kFlowSteps;
        for (int i = 0; i < kFlowSteps; ++i)
            p += kStep * velocity(p + 0.5 * kStep * velocity(p));
        return p;
    }

    // Same as above; also carries small displacements of p, each with a change of the drive.
    template <std::size_t N>
    Vec3 carry(Vec3 p, std::array<Change, N>& changes) const noexcept {
        constexpr double kStep = 1.0 / kFlowSteps;
        for (int i = 0; i < kFlowSteps; ++i) {
            const Local here = localAt(p);
            const Vec3 middle = p + 0.5 * kStep * here.velocity;
            const Local there = localAt(middle);
            for (Change& c : changes) {
                const Vec3 half =
                    c.moved_m + 0.5 * kStep * (here.slope * c.moved_m + here.field.evaluate(c.drive));
                c.moved_m += kStep * (there.slope * half + there.field.evaluate(c.drive));
            }
            p += kStep * there.velocity;
        }
        return p;
    }

    Vec3 velocity(const Vec3& p) const noexcept {
        Cell cell;
        if (!find(p, cell)) return Vec3(0.0);
        const Vec3& share = cell.share;
        const auto row = [&](std::size_t at) {
            return between(CoefficientPair::at(cell.first + at), CoefficientPair::at(cell.first + at + 1),
                           share.x);
        };
        const CoefficientPair near = between(row(0), row(row_), share.y);
        const CoefficientPair far = between(row(slice_), row(slice_ + row_), share.y);
        return between(near, far, share.z).evaluate(drive_);
    }

  private:
    // First node of the cell that contains a point, and the point's position in the cell.
    struct Cell {
        const MotionCoefficients* first = nullptr;
        Vec3 share{0.0};
    };
    struct Local {
        CoefficientPair field{};
        Vec3 velocity{0.0};
        Mat3 slope{0.0};  // of the velocity
    };

    // Returns false outside the grid and for NaN.
    bool find(const Vec3& p, Cell& cell) const noexcept {
        const Vec3 at = (p - origin_m_) * per_m_;
        if (!(at.x >= 0.0 && at.y >= 0.0 && at.z >= 0.0 && at.x < double(last_.x) && at.y < double(last_.y) &&
              at.z < double(last_.z)))
            return false;
        const Index3 low{int(at.x), int(at.y), int(at.z)};
        cell.first = field_ + std::size_t(low.z) * slice_ + std::size_t(low.y) * row_ + std::size_t(low.x);
        cell.share = at - Vec3(low);
        return true;
    }

    Local localAt(const Vec3& p) const noexcept {
        Local local;
        Cell cell;
        if (!find(p, cell)) return local;
        const Vec3& share = cell.share;
        struct Face {
            CoefficientPair value, by_x, by_y;
        };
        const auto face = [&](std::size_t at) {
            const MotionCoefficients* const n = cell.first + at;
            const CoefficientPair low = CoefficientPair::at(n), high = CoefficientPair::at(n + row_);
            const CoefficientPair low_x = CoefficientPair::at(n + 1) - low,
                                  high_x = CoefficientPair::at(n + row_ + 1) - high;
            const CoefficientPair low_value = along(low, low_x, share.x),
                                  high_value = along(high, high_x, share.x);
            const CoefficientPair by_y = high_value - low_value;
            return Face{along(low_value, by_y, share.y), between(low_x, high_x, share.y), by_y};
        };
        const Face near = face(0), far = face(slice_);
        const CoefficientPair by_z = far.value - near.value;
        local.field = along(near.value, by_z, share.z);
        local.velocity = local.field.evaluate(drive_);
        local.slope[0] = between(near.by_x, far.by_x, share.z).evaluate(drive_) * per_m_.x;
        local.slope[1] = between(near.by_y, far.by_y, share.z).evaluate(drive_) * per_m_.y;
        local.slope[2] = by_z.evaluate(drive_) * per_m_.z;
        return local;
    }

    const MotionCoefficients* field_;
    Vec3 origin_m_, per_m_;
    Index3 last_;
    std::size_t row_, slice_;
    Drive drive_;
};

// Largest |v - v_ref|; also used for v'.
double maxDeviation(const SurrogateRange& range, double reference) noexcept {
    return std::max(std::abs(range.low - reference), std::abs(range.high - reference));
}

Side sideAtReference(const MotionModel& m, const Vec3& reference_m) noexcept {
    return cavityLevel_m(m, reference_m) < 0.0 ? Side::inside : Side::outside;
}

// Applies the slide if the point is inside, then the wall.
template <std::size_t N>
Vec3 carryAll(const MotionModel& m, const Drive& drive, Side side, Vec3 p,
              std::array<Change, N>& changes) noexcept {
    if (side == Side::inside) p = Flow(m, m.slide, drive).carry(p, changes);
    return Flow(m, m.wall, drive).carry(p, changes);
}

}  // namespace

double maxNodeDifference(const MotionModel& m, const MotionCoefficients& a,
                         const MotionCoefficients& b) noexcept {
    const double v = maxDeviation(m.v, m.reference.v),
                 rate = maxDeviation(m.rate_per_s, m.reference.rate_per_s);
    double max_m = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
        max_m = std::max(max_m, v * std::abs(double(b.a1_m[c]) - double(a.a1_m[c])) +
                                    rate * std::abs(double(b.a2_m_s[c]) - double(a.a2_m_s[c])));
    return max_m;
}

Vec3 motionField_m(const MotionModel& m, MotionPart part, const Surrogate& now, const Vec3& p) noexcept {
    if (m.empty()) return Vec3(0.0);
    return Flow(m, part == MotionPart::wall ? m.wall : m.slide, makeDrive(m, now)).velocity(p);
}

double cavityLevel_m(const MotionModel& m, const Vec3& p) noexcept {
    if (m.empty()) return 1.0;
    const Vec3 at = m.grid.toVoxels(p);
    const std::array<std::size_t, 3> step = m.grid.strides();
    Index3 low;
    double share[3];
    for (int axis = 0; axis < 3; ++axis) {
        const int last = m.grid.dims[axis] - 1;
        // NaN is treated as the low end.
        const double x = at[axis] > 0.0 ? std::min(at[axis], double(last)) : 0.0;
        low[axis] = std::min(int(x), last - 1);
        share[axis] = x - double(low[axis]);
    }
    const std::size_t first = m.grid.offset(low);
    double sum = 0.0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        double weight = 1.0;
        std::size_t node = first;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const bool up = corner >> axis & 1;
            weight *= up ? share[axis] : 1.0 - share[axis];
            if (up) node += step[axis];
        }
        sum += weight * double(m.level_m[node]);
    }
    return sum;
}

double cavityLevel_m(const MotionModel& m, const Surrogate& now, const Vec3& deformed_m) noexcept {
    const Drive drive = makeDrive(m, now);
    if (m.empty() || drive.isZero()) return cavityLevel_m(m, deformed_m);
    return cavityLevel_m(m, Flow(m, m.wall, -drive).carry(deformed_m));
}

Side sideAt(const MotionModel& m, const Surrogate& now, const Vec3& deformed_m) noexcept {
    return cavityLevel_m(m, now, deformed_m) < 0.0 ? Side::inside : Side::outside;
}

Vec3 deformedFromReference(const MotionModel& m, const Surrogate& now, Side side,
                           const Vec3& reference_m) noexcept {
    const Drive drive = makeDrive(m, now);
    if (m.empty() || drive.isZero()) return reference_m;
    const Vec3 p = side == Side::inside ? Flow(m, m.slide, drive).carry(reference_m) : reference_m;
    return Flow(m, m.wall, drive).carry(p);
}

Vec3 referenceFromDeformed(const MotionModel& m, const Surrogate& now, Side side,
                           const Vec3& deformed_m) noexcept {
    const Drive drive = makeDrive(m, now);
    if (m.empty() || drive.isZero()) return deformed_m;
    const Vec3 p = Flow(m, m.wall, -drive).carry(deformed_m);
    return side == Side::inside ? Flow(m, m.slide, -drive).carry(p) : p;
}

Vec3 deformedFromReference(const MotionModel& m, const Surrogate& now, const Vec3& reference_m) noexcept {
    return deformedFromReference(m, now, sideAtReference(m, reference_m), reference_m);
}

Vec3 referenceFromDeformed(const MotionModel& m, const Surrogate& now, const Vec3& deformed_m) noexcept {
    const Drive drive = makeDrive(m, now);
    if (m.empty() || drive.isZero()) return deformed_m;
    const Vec3 p = Flow(m, m.wall, -drive).carry(deformed_m);
    return cavityLevel_m(m, p) < 0.0 ? Flow(m, m.slide, -drive).carry(p) : p;
}

Mat3 motionJacobian(const MotionModel& m, const Surrogate& now, const Vec3& reference_m) noexcept {
    std::array<Change, 3> axes{Change{Vec3(1.0, 0.0, 0.0)}, {Vec3(0.0, 1.0, 0.0)}, {Vec3(0.0, 0.0, 1.0)}};
    const Drive drive = makeDrive(m, now);
    if (!m.empty() && !drive.isZero()) carryAll(m, drive, sideAtReference(m, reference_m), reference_m, axes);
    return {axes[0].moved_m, axes[1].moved_m, axes[2].moved_m};
}

Vec3 motionVelocity_m_s(const MotionModel& m, const Surrogate& now, double acceleration_per_s2,
                        const Vec3& reference_m) noexcept {
    if (m.empty()) return Vec3(0.0);
    const auto within = [](const SurrogateRange& range, double x) { return x > range.low && x < range.high; };
    std::array<Change, 1> change{Change{Vec3(0.0),
                                        {within(m.v, now.v) ? clampTo(m.rate_per_s, now.rate_per_s) : 0.0,
                                         within(m.rate_per_s, now.rate_per_s) ? acceleration_per_s2 : 0.0}}};
    carryAll(m, makeDrive(m, now), sideAtReference(m, reference_m), reference_m, change);
    return change[0].moved_m;
}

Vec3 follow(LocalMotion& cached, const MotionModel& m, const Surrogate& now, Side side,
            const Vec3& reference_m, const LocalReach& reach) noexcept {
    const Drive drive = makeDrive(m, now);
    const Vec3 delta = reference_m - cached.reference_m;
    const Vec3 breathed =
        cached.by_v_m * (drive.v - cached.v) + cached.by_rate_m_s * (drive.rate - cached.rate_per_s);
    // NaN counts as far away.
    const bool near = cached.known && side == cached.side && glm::length(delta) <= reach.tissue_m &&
                      glm::length(breathed) <= reach.breath_m;
    if (near) return cached.deformed_m + cached.deformed_from_reference * delta + breathed;

    cached = {
        .known = true, .side = side, .reference_m = reference_m, .v = drive.v, .rate_per_s = drive.rate};
    std::array<Change, 5> changes{Change{Vec3(1.0, 0.0, 0.0)},
                                  {Vec3(0.0, 1.0, 0.0)},
                                  {Vec3(0.0, 0.0, 1.0)},
                                  {Vec3(0.0), {1.0, 0.0}},
                                  {Vec3(0.0), {0.0, 1.0}}};
    Vec3 p = reference_m;
    if (!m.empty()) {
        if (side == Side::inside) p = Flow(m, m.slide, drive).carry(p, changes);
        cached.level_m = cavityLevel_m(m, p);
        p = Flow(m, m.wall, drive).carry(p, changes);
    }
    cached.deformed_m = p;
    cached.deformed_from_reference = {changes[0].moved_m, changes[1].moved_m, changes[2].moved_m};
    cached.reference_from_deformed = glm::inverse(cached.deformed_from_reference);
    cached.by_v_m = changes[3].moved_m;
    cached.by_rate_m_s = changes[4].moved_m;
    return p;
}

SideChanges sideChanges(const MotionModel& m, const Surrogate& now, const Vec3& from_m,
                        const Vec3& to_m) noexcept {
    SideChanges changes;
    const Vec3 delta = to_m - from_m;
    const double length_m = std::sqrt(glm::dot(delta, delta));
    const auto level = [&](double share) { return cavityLevel_m(m, now, from_m + share * delta); };
    double share = 0.0, here = level(0.0);
    changes.first = here < 0.0 ? Side::inside : Side::outside;
    if (m.empty() || makeDrive(m, now).isZero()) return changes;
    // Step as far as the level guarantees no zero crossing, but at least kMinSideStep_m. A NaN length
    // ends the loop.
    for (int sample = 0;
         sample < kMaxSideSamples && share * length_m < length_m && changes.count < kMaxSideChanges;
         ++sample) {
        const double free_m = std::fabs(here) / kMaxLevelGradient;
        if (free_m >= (1.0 - share) * length_m) break;
        const double step_m = std::max(free_m, kMinSideStep_m);
        const double next = std::min(1.0, share + step_m / length_m);
        const double there = level(next);
        if ((here < 0.0) != (there < 0.0)) {
            double before = share, after = next;
            while ((after - before) * length_m > kNear_m) {
                const double middle = 0.5 * (before + after);
                if (middle <= before || middle >= after) break;
                ((level(middle) < 0.0) == (here < 0.0) ? before : after) = middle;
            }
            changes.list[std::size_t(changes.count++)] = {before, after};
        }
        share = next, here = there;
    }
    return changes;
}

}  // namespace stylet::patient
