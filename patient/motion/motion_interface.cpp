// Removes the normal component that interpolation leaves. Based on Kaczmarz 1937 (projection onto one linear
// condition after the other), under-relaxed after Censor, Eggermont and Gordon 1983.
#include "patient/motion/motion_interface.h"

#include <algorithm>

#include "base/smoothstep.h"
#include "base/statistics.h"

namespace stylet::patient {
namespace {

constexpr int kSweeps = 12;
constexpr double kFadeCells = 8.0;  // distance outside the surface at which the slide has faded to zero
constexpr double kLiftAlong_m = 0.050, kLiftAcross_m = 0.015;
constexpr int kMaxLiftPasses = 6;
constexpr double kJustInside_m = 1e-7;

// The eight nodes around a point, their weights, and the level and its gradient at the point.
struct LevelSample {
    std::array<std::size_t, 8> node{};
    std::array<double, 8> weight{};
    double level_m = 0.0;
    Vec3 gradient{0.0};
};

LevelSample interpolateLevel(const MotionModel& m, const Vec3& p) {
    const Vec3 at = glm::clamp(m.grid.toVoxels(p), Vec3(0.0), Vec3(m.grid.dims - 1));
    const Index3 low = glm::min(Index3(at), m.grid.dims - 2);
    const Vec3 share = at - Vec3(low);
    LevelSample around;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const Index3 up{int(corner & 1), int(corner >> 1 & 1), int(corner >> 2)};
        Vec3 weight, rise;
        for (int axis = 0; axis < 3; ++axis) {
            weight[axis] = up[axis] ? share[axis] : 1.0 - share[axis];
            rise[axis] = (up[axis] ? 1.0 : -1.0) / m.grid.spacing_m[axis];
        }
        const std::size_t node = m.grid.offset(low + up);
        const double level = double(m.level_m[node]);
        around.node[corner] = node;
        around.weight[corner] = weight.x * weight.y * weight.z;
        around.level_m += around.weight[corner] * level;
        around.gradient += level * Vec3(rise.x * weight.y * weight.z, weight.x * rise.y * weight.z,
                                        weight.x * weight.y * rise.z);
    }
    return around;
}

// Central differences, one-sided at the grid's ends.
Vec3 gradientAtNode(const MotionModel& m, const Index3& i) {
    Vec3 gradient;
    for (int axis = 0; axis < 3; ++axis) {
        Index3 low = i, high = i;
        low[axis] = std::max(0, i[axis] - 1);
        high[axis] = std::min(m.grid.dims[axis] - 1, i[axis] + 1);
        gradient[axis] = double(m.level_m[m.grid.offset(high)] - m.level_m[m.grid.offset(low)]) /
                         (m.grid.spacing_m[axis] * (high[axis] - low[axis]));
    }
    return gradient;
}

bool crossesCell(const MotionModel& m, const Index3& low) {
    float lowest = m.level_m[m.grid.offset(low)], highest_level = lowest;
    for (int corner = 1; corner < 8; ++corner) {
        const float level = m.level_m[m.grid.offset(low + Index3(corner & 1, corner >> 1 & 1, corner >> 2))];
        lowest = std::min(lowest, level), highest_level = std::max(highest_level, level);
    }
    return lowest < 0.0f && highest_level >= 0.0f;
}

using Values = std::array<float, 3>;

Vec3 toVec3(const Values& v) {
    return {double(v[0]), double(v[1]), double(v[2])};
}
void set(Values& v, const Vec3& x) {
    for (int axis = 0; axis < 3; ++axis)
        v[std::size_t(axis)] = float(x[axis]);
}

// A point of the surface with the nodes around it.
struct SurfaceNodes {
    std::array<std::size_t, 8> node{};
    std::array<double, 8> weight{};
    double squares = 0.0;  // sum of the squared weights
    Vec3 normal;
};
SurfaceNodes nodesAround(const MotionModel& m, const SurfacePoint& point) {
    const LevelSample around = interpolateLevel(m, point.reference_m);
    SurfaceNodes at{around.node, around.weight, 0.0, point.normal};
    for (const double weight : at.weight)
        at.squares += weight * weight;
    return at;
}

// Removes `share` of the normal component of the interpolated field at one point, with the smallest change
// to the nodes around it.
void removeNormalComponent(MotionModel& m, const SurfaceNodes& at, Values MotionCoefficients::* part,
                           double share) {
    Vec3 value(0.0);
    for (std::size_t k = 0; k < 8; ++k)
        value += at.weight[k] * toVec3(m.slide[at.node[k]].*part);
    const Vec3 excess = share * glm::dot(value, at.normal) / at.squares * at.normal;
    for (std::size_t k = 0; k < 8; ++k) {
        Values& node = m.slide[at.node[k]].*part;
        set(node, toVec3(node) - at.weight[k] * excess);
    }
}

// Raises the level at each point that is too low. The rise falls to zero at a distance of kLiftAcross_m or,
// along z, kLiftAlong_m. Returns false if no point was too low.
bool lift(MotionModel& m, const std::vector<Vec3>& points_m, double margin_m) {
    const Vec3 reach_m(kLiftAcross_m, kLiftAcross_m, kLiftAlong_m);
    std::vector<float> lifts(m.level_m.size(), 0.0f);
    bool any = false;
    for (const Vec3& p : points_m) {
        const double missing_m = margin_m - interpolateLevel(m, p).level_m;
        if (missing_m <= 0.0) continue;
        any = true;
        const Index3 low = glm::max(Index3(glm::ceil(m.grid.toVoxels(p - reach_m))), Index3(0));
        const Index3 high = glm::min(Index3(glm::floor(m.grid.toVoxels(p + reach_m))), m.grid.dims - 1);
        forEachVoxel(low, high, [&](const Index3& i) {
            const Vec3 away = (m.grid.centre(i) - p) / reach_m;
            const double near = 1.0 - glm::dot(away, away);
            if (near <= 0.0) return;
            float& highest = lifts[m.grid.offset(i)];
            highest = std::max(highest, float(missing_m * near * near));
        });
    }
    for (std::size_t i = 0; i < lifts.size(); ++i)
        m.level_m[i] += lifts[i];
    return any;
}

}  // namespace

std::vector<SurfacePoint> cavitySurface(const MotionModel& m) {
    std::vector<SurfacePoint> points;
    if (m.empty()) return points;
    forEachVoxel(m.grid, [&](const Index3& low) {
        if (!m.grid.contains(low + 1) || !crossesCell(m, low)) return;
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 share = 0.25 + 0.5 * Vec3(corner & 1, corner >> 1 & 1, corner >> 2);
            Vec3 p = m.grid.origin_m + m.grid.spacing_m * (Vec3(low) + share);
            for (int step = 0; step < 4; ++step) {
                const LevelSample around = interpolateLevel(m, p);
                const double steepness2 = glm::dot(around.gradient, around.gradient);
                if (steepness2 < 1e-6) break;
                p -= around.level_m / steepness2 * around.gradient;
            }
            const Vec3 at = m.grid.toVoxels(p) - Vec3(low);
            if (at.x < 0.0 || at.y < 0.0 || at.z < 0.0 || at.x > 1.0 || at.y > 1.0 || at.z > 1.0) continue;
            const LevelSample around = interpolateLevel(m, p);
            const double steepness = std::sqrt(glm::dot(around.gradient, around.gradient));
            if (steepness < 1e-3 || std::fabs(around.level_m) > 1e-6) continue;
            points.push_back({p, around.gradient / steepness});
        }
    });
    return points;
}

void raiseLevelAt(MotionModel& m, const std::vector<Vec3>& points_m, double margin_m) {
    for (int sweep = 0; sweep < kMaxLiftPasses && lift(m, points_m, margin_m); ++sweep) {
    }
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool done = true;
        for (const Vec3& p : points_m) {
            const LevelSample around = interpolateLevel(m, p);
            if (around.level_m >= margin_m) continue;
            done = false;
            double squares = 0.0;
            for (const double weight : around.weight)
                squares += weight * weight;
            // Slightly more than necessary, so that the sweeps converge.
            const double lift = (margin_m + 1e-5 - around.level_m) / squares;
            for (std::size_t k = 0; k < 8; ++k)
                m.level_m[around.node[k]] += float(lift * around.weight[k]);
        }
        if (done) return;
    }
}

void makeTangential(MotionModel& m, double depth_m) {
    if (m.empty()) return;
    const Vec3 s = m.grid.spacing_m;
    const double cell_m = std::max({s.x, s.y, s.z});
    forEachVoxel(m.grid, [&](const Index3& i) {
        const std::size_t at = m.grid.offset(i);
        const double level = double(m.level_m[at]);
        // below this level no node belongs to a cell that the surface crosses
        const double all_m = -2.0 * cell_m;
        const double share = smoothStep(std::min(-depth_m, all_m - cell_m), all_m, level);
        const double kept =
            m.grid.atBorder(i) ? 0.0 : 1.0 - smoothStep(2.0 * cell_m, kFadeCells * cell_m, level);
        const Vec3 gradient = gradientAtNode(m, i);
        const double steepness2 = glm::dot(gradient, gradient);
        for (Values MotionCoefficients::* part : {&MotionCoefficients::a1_m, &MotionCoefficients::a2_m_s}) {
            Vec3 value = toVec3(m.slide[at].*part);
            if (steepness2 > 1e-6) value -= share * glm::dot(value, gradient) / steepness2 * gradient;
            set(m.slide[at].*part, kept * value);
        }
    });
    std::vector<SurfaceNodes> surface;
    for (const SurfacePoint& point : cavitySurface(m))
        surface.push_back(nodesAround(m, point));
    // The surface has kinks between cells, so no field is tangential everywhere. A decreasing share per
    // sweep converges close to the least-squares solution. Full steps would make each cell fit only its
    // last point.
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        const double share = 1.0 / (1.0 + sweep);
        for (const SurfaceNodes& point : surface) {
            removeNormalComponent(m, point, &MotionCoefficients::a1_m, share);
            removeNormalComponent(m, point, &MotionCoefficients::a2_m_s, share);
        }
    }
    forEachVoxel(m.grid, [&](const Index3& i) {
        if (m.grid.atBorder(i)) m.slide[m.grid.offset(i)] = {};
    });
}

InterfaceError measureInterface(const MotionModel& m, const Surrogate& now) {
    InterfaceError error;
    std::vector<double> all;
    for (const SurfacePoint& point : cavitySurface(m)) {
        const Vec3 inner = point.reference_m - kJustInside_m * point.normal;
        const Vec3 outer = point.reference_m + kJustInside_m * point.normal;
        const Vec3 moved = deformedFromReference(m, now, inner);
        const Vec3 off = moved - deformedFromReference(m, now, outer);
        const double slip = std::sqrt(glm::dot(off, off));
        const double level = cavityLevel_m(m, now, moved);
        error.worst_overlap_m = std::max(error.worst_overlap_m, level);
        error.worst_gap_m = std::max(error.worst_gap_m, -level);
        error.mean_m += std::fabs(level);
        error.mean_slip_m += slip;
        error.max_slip_m = std::max(error.max_slip_m, slip);
        all.push_back(std::fabs(level));
    }
    error.points = all.size();
    if (all.empty()) return error;
    error.mean_m /= double(all.size());
    error.mean_slip_m /= double(all.size());
    error.p99_m = lowerQuantile(std::move(all), 0.99);
    return error;
}

InterfaceError worstInterface(const MotionModel& m) {
    InterfaceError worst;
    for (const Surrogate& breath : cornerBreaths(m)) {
        const InterfaceError e = measureInterface(m, breath);
        worst.points = e.points;
        for (double InterfaceError::* const what :
             {&InterfaceError::mean_m, &InterfaceError::p99_m, &InterfaceError::worst_gap_m,
              &InterfaceError::worst_overlap_m, &InterfaceError::mean_slip_m, &InterfaceError::max_slip_m})
            worst.*what = std::max(worst.*what, e.*what);
    }
    return worst;
}

std::array<Surrogate, 4> cornerBreaths(const MotionModel& m) {
    return {Surrogate{m.v.low, m.rate_per_s.low}, Surrogate{m.v.low, m.rate_per_s.high},
            Surrogate{m.v.high, m.rate_per_s.low}, Surrogate{m.v.high, m.rate_per_s.high}};
}

double minJacobian(const MotionModel& model, double scale) {
    MotionModel m = model;
    m.v = m.rate_per_s = {-1e6, 1e6};
    double lowest = 1.0;
    for (const Surrogate& end : cornerBreaths(model)) {
        const Surrogate now{m.reference.v + scale * (end.v - m.reference.v),
                            m.reference.rate_per_s + scale * (end.rate_per_s - m.reference.rate_per_s),
                            m.reference.creep_v};
        forEachVoxel(m.grid, [&](const Index3& low) {
            if (!m.grid.contains(low + 1)) return;
            for (const double share : {0.25, 0.75}) {
                const Vec3 p = m.grid.origin_m + m.grid.spacing_m * (Vec3(low) + share);
                lowest = std::min(lowest, glm::determinant(motionJacobian(m, now, p)));
            }
        });
    }
    return lowest;
}

}  // namespace stylet::patient
