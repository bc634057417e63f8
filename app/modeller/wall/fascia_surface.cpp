#include "app/modeller/wall/fascia_surface.h"

#include <algorithm>
#include <cmath>

#include "app/modeller/image/graph_cut.h"
#include "app/modeller/image/vector_field.h"
#include "base/parallel.h"

namespace stylet::modeller {

namespace {

// --- Evidence ---

// Darker tissue counts as fat: the edge of lung then lies where the pleura is. Bone counts as muscle.
constexpr float kDarkest_hu = -110.0f, kBrightest_hu = 75.0f;
constexpr float kCertainLine_hu =
    30.0f;  // a line that is darker by this, or a step of kCertainEdge_hu in 2 mm, is certain
constexpr float kCertainEdge_hu = 100.0f;
constexpr float kOuterMuscle_hu = 20.0f;  // muscle outside the fascia is brighter
// Samples that are compared with the middle: beside a line, outside a step.
constexpr int kLineSide = 3, kLineSideEnd = 6, kEdgeHalf = 2;
// Fluid (ascites) inside the diaphragm is visible if it reaches sample kFluidEnd. A mixture of fat and organ
// has such values, too, but varies.
constexpr float kDarkestFluid_hu = -10.0f, kBrightestFluid_hu = 30.0f, kSameFluid_hu = 10.0f;
constexpr int kFluidEnd = 10;

float meanOver(std::span<const float> p, int first, int last) {
    float sum = 0.0f;
    for (int i = first; i <= last; ++i)
        sum += p[std::size_t(std::clamp(i, 0, int(p.size()) - 1))];
    return sum / float(last - first + 1);
}

// --- The unfolded volume ---

constexpr double kSearch_m = 0.012;
constexpr int kRaySteps = 2 * int(kSearch_m / kProfileStep_m) + 1;
constexpr int kSeamCells = 12;           // cells repeated beyond each end of a turn
constexpr double kAlongWall_m = 0.0015;  // noise is averaged so far along the surface
// Costs: of a face that is not visible 1; of a step of the surface between neighbouring cells; of leaving the
// bounds, and of being farther from the usual place under a rib than kRibTolerance_m, per metre. kCrossing
// excludes surfaces that pass a ray twice.
constexpr float kNeighbourStep = 0.08f, kCrossing = 2.0f, kOutOfBounds_per_m = 400.0f, kOffRib_per_m = 250.0f;
// Distance from the upper bound at a rib's middle. From 0.15 to 0.45 mm, paths enter the fascia within 0.2 mm
// of the true place on average (seeds 61 and 62).
constexpr double kUnderRib_m = 0.0003, kRibTolerance_m = 0.001;
// The diaphragm's thickness, and the weight of a line that may be the diaphragm's own face.
constexpr double kThinnest_m = 0.002, kThickest_m = 0.006, kThicknessStep_m = 0.0001;
constexpr double kMaxObliquity = 1.5;  // beyond it, the wall is too steep for its rays
constexpr float kMayBeDiaphragm = 0.5f, kMinSeen = 0.05f;

double offsetOf(int step) {
    return (step - kRaySteps / 2) * kProfileStep_m;
}

// Mean over nine samples in the plane across a ray.
float tangentialMean(const FloatVolume& hu, const WallSurface& s, double phi, double z_m, double r_m) {
    float sum = 0.0f;
    for (const double along : {-kAlongWall_m, 0.0, kAlongWall_m})
        for (const double up : {-kAlongWall_m, 0.0, kAlongWall_m}) {
            const Vec3 p{s.axis_m.x + r_m * std::cos(phi) - along * std::sin(phi),
                         s.axis_m.y + r_m * std::sin(phi) + along * std::cos(phi), z_m + up};
            sum += valueAt(hu, p, kDarkest_hu);
        }
    return sum / 9.0f;
}

// The fascia's usual radius under the middle of a rib, or 0 in other cells. A rib is nearest to the axis at
// its middle.
double radiusUnderRib(const WallSurface& s, const RadiusBounds& bounds, int z, int a) {
    constexpr int kHalfRib = 2;
    const double high_m = bounds.high_m[s.cell(z, a)];
    if (high_m >= kFarOff_m) return 0.0;
    for (int dz = -kHalfRib; dz <= kHalfRib; ++dz)
        if (bounds.high_m[s.cell(z + dz, a)] < high_m) return 0.0;
    return high_m - kUnderRib_m;
}

float priorCost(double r_m, double low_m, double high_m, double under_rib_m) {
    const double out_m = std::max({0.0, low_m - r_m, r_m - high_m});
    const double off_m =
        under_rib_m > 0.0 ? std::max(0.0, std::fabs(r_m - under_rib_m) - kRibTolerance_m) : 0.0;
    return kOutOfBounds_per_m * float(out_m) + kOffRib_per_m * float(off_m);
}

// Values per step of each ray. Index: cell * kRaySteps + step.
using RayValues = std::vector<float>;
struct RayEvidence {
    RayValues edge, line;
};

RayEvidence traceRays(const FasciaInput& in, const WallSurface& s, const RadiusBounds& bounds) {
    FloatVolume hu(in.ct.grid);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i)
        hu.voxels[i] = std::clamp(float(in.ct.voxels[i]), kDarkest_hu, kBrightest_hu);
    RayEvidence seen;
    seen.edge = seen.line = RayValues(s.radius_m.size() * kRaySteps);
    parallelFor(processorCount(), s.levels, [&](int z) {
        std::vector<float> profile(kRaySteps);
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t first = s.cell(z, a) * kRaySteps;
            const double phi = a * kFullTurn / s.angles, z_m = s.z_begin_m + z * s.z_step_m;
            for (int k = 0; k < kRaySteps; ++k)
                profile[std::size_t(k)] =
                    tangentialMean(hu, s, phi, z_m, s.radius_m[s.cell(z, a)] + offsetOf(k));
            const bool at_ribs = boneNear(bounds, s, z, a);
            for (int k = 0; k < kRaySteps; ++k) {
                const WallEvidence e = wallEvidence(profile, k);
                seen.edge[first + std::size_t(k)] = e.edge;
                seen.line[first + std::size_t(k)] = at_ribs ? e.line : 0.0f;
            }
        }
    });
    return seen;
}

// Length of a ray in a layer of the wall per thickness of the layer. 1 where the ray is perpendicular.
double obliquity(const WallSurface& s, int z, int a) {
    const double arc_m = s.radius_m[s.cell(z, a)] * kFullTurn / s.angles;
    const double up = (s.radius_m[s.cell(z + 1, a)] - s.radius_m[s.cell(z - 1, a)]) / (2.0 * s.z_step_m);
    const double along = (s.radius_m[s.cell(z, a + 1)] - s.radius_m[s.cell(z, a - 1)]) / (2.0 * arc_m);
    return std::min(kMaxObliquity, std::sqrt(1.0 + up * up + along * along));
}

// Linear between the steps of the ray.
float evidenceAt(const RayValues& seen, const WallSurface& s, std::size_t cell, double r_m) {
    const double at = (r_m - s.radius_m[cell]) / kProfileStep_m + kRaySteps / 2;
    if (!(at >= 0.0 && at < kRaySteps - 1)) return 0.0f;
    const float* below = &seen[cell * kRaySteps + std::size_t(at)];
    return std::lerp(below[0], below[1], float(at - std::floor(at)));
}

// The usual distance, across the wall, from the fascia's place under the ribs to the diaphragm's inner face.
// 0 if no line is visible there.
double measureDiaphragm(const RayValues& lines, const WallSurface& s, const RadiusBounds& bounds) {
    double best_m = 0.0, best = 0.0, count = 0.0;
    for (double d_m = kThinnest_m; d_m <= kThickest_m; d_m += kThicknessStep_m) {
        double sum = 0.0;
        count = 0.0;
        for (int z = 0; z < s.levels; ++z)
            for (int a = 0; a < s.angles; ++a)
                if (const double r_m = radiusUnderRib(s, bounds, z, a); r_m > 0.0) {
                    sum += double(evidenceAt(lines, s, s.cell(z, a), r_m - d_m * obliquity(s, z, a)));
                    count += 1.0;
                }
        if (sum > best) best = sum, best_m = d_m;
    }
    // A sum that is largest at the thinnest distance comes from lines near the ribs, not from a diaphragm.
    return best_m > kThinnest_m && best > double(kMinSeen) * count ? best_m : 0.0;
}

// Evidence of the fascia: an edge, or one diaphragm thickness outside a line. The line itself may also be the
// fascia.
RayValues fasciaEvidence(const RayEvidence& seen, const WallSurface& s, const RadiusBounds& bounds) {
    const double diaphragm_m = measureDiaphragm(seen.line, s, bounds);
    RayValues evidence = seen.edge;
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t cell = s.cell(z, a);
            const double along_ray_m = diaphragm_m * obliquity(s, z, a);
            for (int k = 0; k < kRaySteps; ++k) {
                const std::size_t at = cell * kRaySteps + std::size_t(k);
                float line = kMayBeDiaphragm * seen.line[at];
                if (diaphragm_m > 0.0)
                    line = std::max(
                        line, evidenceAt(seen.line, s, cell, s.radius_m[cell] + offsetOf(k) - along_ray_m));
                evidence[at] = std::max(evidence[at], line);
            }
        }
    return evidence;
}

RayValues surfaceCost(const RayValues& evidence, const WallSurface& s, const RadiusBounds& bounds) {
    RayValues cost(evidence.size());
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t cell = s.cell(z, a);
            const double under_rib_m = radiusUnderRib(s, bounds, z, a);
            for (int k = 0; k < kRaySteps; ++k) {
                const std::size_t at = cell * kRaySteps + std::size_t(k);
                cost[at] = 1.0f - evidence[at] +
                           priorCost(s.radius_m[cell] + offsetOf(k), bounds.low_m[cell], bounds.high_m[cell],
                                     under_rib_m);
            }
        }
    return cost;
}

// The cheapest surface as a step per cell. The object of the cut is the inside; its border along a ray is the
// surface.
std::vector<int> cheapestSurface(const WallSurface& s, const RayValues& cost) {
    CutProblem problem;
    const Grid grid{Index3(kRaySteps + 1, s.angles + 2 * kSeamCells, s.levels), Vec3(1.0), Vec3(0.0)};
    problem.state = Mask(grid, std::uint8_t(CutState::free));
    problem.preference = FloatVolume(grid);
    forEachVoxel(grid, [&](const Index3& i) {
        if (i.x == 0) problem.state[i] = std::uint8_t(CutState::object);
        if (i.x == kRaySteps) problem.state[i] = std::uint8_t(CutState::background);
    });
    problem.link = [&](std::size_t i, std::size_t j) {
        if (std::max(i, j) - std::min(i, j) > 1) return kNeighbourStep;
        const Index3 at = grid.voxelAt(std::min(i, j));
        return kCrossing + cost[s.cell(at.z, at.y - kSeamCells) * kRaySteps + std::size_t(at.x)];
    };
    const Mask inside = minimumCut(problem);
    std::vector<int> step(s.radius_m.size(), 0);
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            int& k = step[s.cell(z, a)];
            while (k + 1 < kRaySteps && inside[{k + 1, a + kSeamCells, z}])
                ++k;
        }
    return step;
}

}  // namespace

WallEvidence wallEvidence(std::span<const float> p, int k) {
    const float outside = meanOver(p, k + kLineSide, k + kLineSideEnd),
                inside = meanOver(p, k - kLineSideEnd, k - kLineSide);
    float line = (std::min(outside, inside) - meanOver(p, k - 1, k + 1)) / kCertainLine_hu;
    const float slope = meanOver(p, k + kEdgeHalf, k + kEdgeHalf) - meanOver(p, k - kEdgeHalf, k - kEdgeHalf);
    const auto isFluid = [](float hu) { return hu > kDarkestFluid_hu && hu < kBrightestFluid_hu; };
    const float deep = meanOver(p, k - kFluidEnd, k - kLineSideEnd - 1);
    if (isFluid(inside) && isFluid(deep) && std::fabs(inside - deep) < kSameFluid_hu)
        line = std::max(line, std::min(slope, outside - inside) / kCertainLine_hu);
    // Behind a thin layer of fat between two muscles, the profile rises again.
    const float edge = std::min(slope, outside - inside) / kCertainEdge_hu;
    const float wall = std::clamp(outside / kOuterMuscle_hu, 0.0f, 1.0f);
    return {wall * std::clamp(edge, 0.0f, 1.0f), wall * std::clamp(line, 0.0f, 1.0f)};
}

ObservedFascia observeFascia(const FasciaInput& in, const WallSurface& near, const RadiusBounds& bounds) {
    constexpr int kRefine = 2;  // steps to each side over which the position is averaged
    const RayValues evidence = fasciaEvidence(traceRays(in, near, bounds), near, bounds);
    const std::vector<int> step = cheapestSurface(near, surfaceCost(evidence, near, bounds));
    ObservedFascia out{near.radius_m, std::vector<double>(near.radius_m.size(), 0.0)};
    for (std::size_t cell = 0; cell < step.size(); ++cell) {
        double sum = 0.0, moment = 0.0;
        for (int k = std::max(0, step[cell] - kRefine); k <= std::min(kRaySteps - 1, step[cell] + kRefine);
             ++k) {
            const double e = double(evidence[cell * kRaySteps + std::size_t(k)]);
            sum += e, moment += e * offsetOf(k);
            out.weight[cell] = std::max(out.weight[cell], e);
        }
        out.radius_m[cell] += sum > 0.0 ? moment / sum : offsetOf(step[cell]);
    }
    return out;
}

}  // namespace stylet::modeller
