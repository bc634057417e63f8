// Based on Wilms et al. 2014 and Arsigny et al. 2006; see motion.h. Hashed: double precision, no libm
// transcendental.
#include "patient/motion.h"

#include <algorithm>

namespace stylet::patient {
namespace {

constexpr double kNear_m = 1e-8;        // how closely a change of sides is found
constexpr double kSteepestLevel = 2.0;  // of a level seen through the breath, per metre
constexpr double kShortestLook_m = 2e-4;
constexpr int kMostLooks = 4096;

// What the surrogate is against the breath of the CT, clamped.
struct Drive {
    double v = 0.0, rate = 0.0;
    bool still() const noexcept { return v == 0.0 && rate == 0.0; }
    Drive operator-() const noexcept { return {-v, -rate}; }
};

// Written so that what is not a number is the lower end.
double clampTo(const SurrogateRange& range, double x) noexcept {
    return x > range.low ? std::min(x, range.high) : range.low;
}

Drive driveOf(const MotionModel& m, const Surrogate& now) noexcept {
    return {clampTo(m.v, now.v) - m.reference.v + (now.creep_v - m.reference.creep_v),
            clampTo(m.rate_per_s, now.rate_per_s) - m.reference.rate_per_s};
}

// The cell of a point and where in it the point lies.
struct Cell {
    std::size_t first = 0;
    Vec3 share{0.0};
};

// One field under one drive.
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

    // The same for p and for small changes d of it, while the drive itself changes by `change`.
    template <std::size_t N>
    Vec3 carry(Vec3 p, std::array<Vec3, N>& d, const Drive& change) const noexcept {
        constexpr double kStep = 1.0 / kFlowSteps;
        for (int i = 0; i < kFlowSteps; ++i) {
            const Local here = localAt(p, change);
            const Vec3 middle = p + 0.5 * kStep * here.velocity;
            const Local there = localAt(middle, change);
            for (Vec3& v : d) {
                const Vec3 half = v + 0.5 * kStep * (here.slope * v + here.push);
                v += kStep * (there.slope * half + there.push);
            }
            p += kStep * there.velocity;
        }
        return p;
    }

    Vec3 velocity(const Vec3& p) const noexcept {
        Cell cell;
        if (!find(p, cell)) return Vec3(0.0);
        const Vec3 high = cell.share, low = 1.0 - high;
        double sum[6] = {};
        const auto addPair = [&](std::size_t at, double weight) {
            const MotionCoefficients* const n = field_ + cell.first + at;
            const double left = weight * low.x, right = weight * high.x;
            for (std::size_t c = 0; c < 3; ++c) {
                sum[c] += left * double(n[0].a1_m[c]) + right * double(n[1].a1_m[c]);
                sum[c + 3] += left * double(n[0].a2_m_s[c]) + right * double(n[1].a2_m_s[c]);
            }
        };
        addPair(0, low.y * low.z), addPair(row_, high.y * low.z);
        addPair(slice_, low.y * high.z), addPair(slice_ + row_, high.y * high.z);
        return Vec3(sum[0], sum[1], sum[2]) * drive_.v + Vec3(sum[3], sum[4], sum[5]) * drive_.rate;
    }

  private:
    struct Local {
        Vec3 velocity{0.0}, push{0.0};  // of the drive, and of its change
        Mat3 slope{0.0};                // of the velocity
    };

    // False beyond the grid, and for what is not a number.
    bool find(const Vec3& p, Cell& cell) const noexcept {
        const Vec3 at = (p - origin_m_) * per_m_;
        if (!(at.x >= 0.0 && at.y >= 0.0 && at.z >= 0.0 && at.x < double(last_.x) && at.y < double(last_.y) &&
              at.z < double(last_.z)))
            return false;
        const Index3 low{int(at.x), int(at.y), int(at.z)};
        cell.first = std::size_t(low.z) * slice_ + std::size_t(low.y) * row_ + std::size_t(low.x);
        cell.share = at - Vec3(low);
        return true;
    }

    Local localAt(const Vec3& p, const Drive& change) const noexcept {
        Local local;
        Cell cell;
        if (!find(p, cell)) return local;
        for (int corner = 0; corner < 8; ++corner) {
            const int up[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
            Vec3 weight, rise;
            for (int axis = 0; axis < 3; ++axis) {
                weight[axis] = up[axis] ? cell.share[axis] : 1.0 - cell.share[axis];
                rise[axis] = up[axis] ? per_m_[axis] : -per_m_[axis];
            }
            const MotionCoefficients& n = field_[cell.first + std::size_t(up[2]) * slice_ +
                                                 std::size_t(up[1]) * row_ + std::size_t(up[0])];
            const Vec3 a1(double(n.a1_m[0]), double(n.a1_m[1]), double(n.a1_m[2]));
            const Vec3 a2(double(n.a2_m_s[0]), double(n.a2_m_s[1]), double(n.a2_m_s[2]));
            const Vec3 w = a1 * drive_.v + a2 * drive_.rate;
            const double share = weight.x * weight.y * weight.z;
            local.velocity += share * w;
            local.push += share * (a1 * change.v + a2 * change.rate);
            local.slope[0] += w * (rise.x * weight.y * weight.z);
            local.slope[1] += w * (weight.x * rise.y * weight.z);
            local.slope[2] += w * (weight.x * weight.y * rise.z);
        }
        return local;
    }

    const MotionCoefficients* field_;
    Vec3 origin_m_, per_m_;
    Index3 last_;
    std::size_t row_, slice_;
    Drive drive_;
};

}  // namespace

Vec3 motionField_m(const MotionModel& m, MotionPart part, const Surrogate& now, const Vec3& p) noexcept {
    if (m.empty()) return Vec3(0.0);
    return Flow(m, part == MotionPart::wall ? m.wall : m.slide, driveOf(m, now)).velocity(p);
}

double cavityLevel_m(const MotionModel& m, const Vec3& p) noexcept {
    if (m.empty()) return 1.0;
    const Vec3 at = m.grid.toVoxels(p);
    std::size_t first = 0, step[3];
    double share[3];
    std::size_t stride = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const int last = m.grid.dims[axis] - 1;
        // NaN ends at the low side.
        const double x = at[axis] > 0.0 ? std::min(at[axis], double(last)) : 0.0;
        const int low = std::min(int(x), last - 1);
        share[axis] = x - double(low);
        first += std::size_t(low) * stride;
        step[axis] = stride;
        stride *= std::size_t(m.grid.dims[axis]);
    }
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
    const Drive drive = driveOf(m, now);
    if (m.empty() || drive.still()) return cavityLevel_m(m, deformed_m);
    return cavityLevel_m(m, Flow(m, m.wall, -drive).carry(deformed_m));
}

Side sideOf(const MotionModel& m, const Surrogate& now, const Vec3& deformed_m) noexcept {
    return cavityLevel_m(m, now, deformed_m) < 0.0 ? Side::inside : Side::outside;
}

Vec3 deformedFromReference(const MotionModel& m, const Surrogate& now, Side side,
                           const Vec3& reference_m) noexcept {
    const Drive drive = driveOf(m, now);
    if (m.empty() || drive.still()) return reference_m;
    const Vec3 p = side == Side::inside ? Flow(m, m.slide, drive).carry(reference_m) : reference_m;
    return Flow(m, m.wall, drive).carry(p);
}

Vec3 referenceFromDeformed(const MotionModel& m, const Surrogate& now, Side side,
                           const Vec3& deformed_m) noexcept {
    const Drive drive = driveOf(m, now);
    if (m.empty() || drive.still()) return deformed_m;
    const Vec3 p = Flow(m, m.wall, -drive).carry(deformed_m);
    return side == Side::inside ? Flow(m, m.slide, -drive).carry(p) : p;
}

Vec3 deformedFromReference(const MotionModel& m, const Surrogate& now, const Vec3& reference_m) noexcept {
    const bool inside = cavityLevel_m(m, reference_m) < 0.0;
    return deformedFromReference(m, now, inside ? Side::inside : Side::outside, reference_m);
}

Vec3 referenceFromDeformed(const MotionModel& m, const Surrogate& now, const Vec3& deformed_m) noexcept {
    const Drive drive = driveOf(m, now);
    if (m.empty() || drive.still()) return deformed_m;
    const Vec3 p = Flow(m, m.wall, -drive).carry(deformed_m);
    return cavityLevel_m(m, p) < 0.0 ? Flow(m, m.slide, -drive).carry(p) : p;
}

Mat3 motionJacobian(const MotionModel& m, const Surrogate& now, const Vec3& reference_m) noexcept {
    std::array<Vec3, 3> columns{Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0)};
    const Drive drive = driveOf(m, now);
    if (!m.empty() && !drive.still()) {
        Vec3 p = reference_m;
        if (cavityLevel_m(m, p) < 0.0) p = Flow(m, m.slide, drive).carry(p, columns, {});
        Flow(m, m.wall, drive).carry(p, columns, {});
    }
    return {columns[0], columns[1], columns[2]};
}

Vec3 motionVelocity_m_s(const MotionModel& m, const Surrogate& now, double acceleration_per_s2,
                        const Vec3& reference_m) noexcept {
    if (m.empty()) return Vec3(0.0);
    const auto within = [](const SurrogateRange& range, double x) { return x > range.low && x < range.high; };
    const Drive drive = driveOf(m, now);
    const Drive change{within(m.v, now.v) ? clampTo(m.rate_per_s, now.rate_per_s) : 0.0,
                       within(m.rate_per_s, now.rate_per_s) ? acceleration_per_s2 : 0.0};
    std::array<Vec3, 1> moved{Vec3(0.0)};
    Vec3 p = reference_m;
    if (cavityLevel_m(m, p) < 0.0) p = Flow(m, m.slide, drive).carry(p, moved, change);
    Flow(m, m.wall, drive).carry(p, moved, change);
    return moved[0];
}

SideChanges sideChanges(const MotionModel& m, const Surrogate& now, const Vec3& from_m,
                        const Vec3& to_m) noexcept {
    SideChanges changes;
    const Vec3 way = to_m - from_m;
    const double length_m = std::sqrt(glm::dot(way, way));
    const auto level = [&](double share) { return cavityLevel_m(m, now, from_m + share * way); };
    double share = 0.0, here = level(0.0);
    changes.first = here < 0.0 ? Side::inside : Side::outside;
    if (m.empty() || driveOf(m, now).still()) return changes;
    // As far as the level allows without meeting its zero, but no shorter than is worth a look. A length that
    // is not a number ends the loop.
    for (int look = 0; look < kMostLooks && share * length_m < length_m && changes.count < kMaxSideChanges;
         ++look) {
        const double free_m = std::fabs(here) / kSteepestLevel;
        if (free_m >= (1.0 - share) * length_m) break;
        const double look_m = std::max(free_m, kShortestLook_m);
        const double next = std::min(1.0, share + look_m / length_m);
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
