#include "app/modeller/motion/motion_cavity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"

namespace stylet::modeller {

namespace {

constexpr float kAir_hu = -400.0f, kBone_hu = 250.0f;
constexpr int kAngles = 180;
constexpr double kBoneWithin_m = 0.020;  // search distance for ribs behind the lung
constexpr double kHalfRibSpacing_m =
    0.015;                              // half the rib spacing; ribs are searched up and down by this much
constexpr double kSlopeOver_m = 0.020;  // length over which the wall's slope is measured for extrapolation
constexpr double kMaxSlope = 0.6;
constexpr double kBeforeBone_m = 0.0015, kAroundSpine_m = 0.003;
constexpr double kBeyondEdge_m = 0.010, kNearEdge_m = 0.003;
constexpr double kClosedShare = 0.6;  // minimum share of the lung levels near an angle with a rib behind them
constexpr int kAround = 8;            // number of angles on each side that are considered together
constexpr std::size_t kMinLungVoxels = 1000;

// Distances from an upright axis to lung, bone and image edge, for each angle and level.
struct Rays {
    Grid grid;
    double x_m = 0.0, y_m = 0.0;
    std::vector<double> lung_m, bone_m, edge_m, wall_m;  // bone_m: behind the lung; wall_m < 0: unknown
    std::vector<unsigned char> open;                     // no wall in the image

    std::size_t at(int angle, int z) const {
        return std::size_t(z) * kAngles + std::size_t((angle % kAngles + kAngles) % kAngles);
    }
};

Mask airOfAnyPhase(const std::vector<Phase>& phases) {
    Mask air(phases.front().hu.grid);
    for (const Phase& phase : phases)
        for (std::size_t i = 0; i < air.voxels.size(); ++i)
            air.voxels[i] |= phase.hu.voxels[i] < kAir_hu;
    keepLargestComponent(air);
    return air;
}

Mask averageBone(const std::vector<Phase>& phases) {
    Mask bone(phases.front().hu.grid);
    for (std::size_t i = 0; i < bone.voxels.size(); ++i) {
        float sum = 0.0f;
        for (const Phase& phase : phases)
            sum += phase.hu.voxels[i];
        bone.voxels[i] = sum > kBone_hu * float(phases.size());
    }
    return bone;
}

Rays castRays(const Mask& lung, const Mask& bone) {
    Rays r;
    r.grid = lung.grid;
    std::size_t count = 0;
    forEachVoxel(r.grid, [&](const Index3& i) {
        if (!lung[i]) return;
        const Vec3 p = r.grid.centre(i);
        r.x_m += p.x, r.y_m += p.y, ++count;
    });
    if (count < kMinLungVoxels) throw ImportError("the phases show no lung, so no cavity is found");
    r.x_m /= double(count), r.y_m /= double(count);

    const std::size_t rays = std::size_t(r.grid.dims.z) * kAngles;
    r.lung_m.assign(rays, 0.0), r.bone_m.assign(rays, 1e3), r.edge_m.assign(rays, 0.0);
    r.wall_m.assign(rays, -1.0), r.open.assign(rays, 0);
    const double step_m = 0.5 * std::min(r.grid.spacing_m.x, r.grid.spacing_m.y);
    parallelFor(processorCount(), r.grid.dims.z, [&](int z) {
        for (int a = 0; a < kAngles; ++a) {
            const double phi = a * 2.0 * std::numbers::pi / kAngles;
            const std::size_t at = r.at(a, z);
            for (double radius_m = 0.0;; radius_m += step_m) {
                const Vec3 p(r.x_m + radius_m * std::cos(phi), r.y_m + radius_m * std::sin(phi),
                             r.grid.origin_m.z + z * r.grid.spacing_m.z);
                const Index3 i = r.grid.nearest(p);
                if (!r.grid.contains(i)) break;
                r.edge_m[at] = radius_m;
                if (lung[i]) r.lung_m[at] = radius_m, r.bone_m[at] = 1e3;
                if (bone[i] && r.bone_m[at] > 1e2) r.bone_m[at] = radius_m;
            }
        }
    });
    return r;
}

bool reachesEdge(const Rays& r, std::size_t at) {
    return r.lung_m[at] > 0.0 && r.edge_m[at] - r.lung_m[at] < kNearEdge_m;
}

// Sets the wall to the lung's surface where a rib passes behind the lung, at this level or slightly above or
// below.
void findWall(Rays& r) {
    const int reach = int(kHalfRibSpacing_m / r.grid.spacing_m.z);
    for (int z = 0; z < r.grid.dims.z; ++z)
        for (int a = 0; a < kAngles; ++a) {
            const std::size_t at = r.at(a, z);
            if (r.lung_m[at] <= 0.0 || reachesEdge(r, at)) continue;
            for (int k = std::max(0, z - reach); k <= std::min(r.grid.dims.z - 1, z + reach); ++k) {
                const double behind_m = r.bone_m[r.at(a, k)] - r.lung_m[at];
                if (behind_m > 0.0 && behind_m < kBoneWithin_m) {
                    r.wall_m[at] = r.lung_m[at];
                    break;
                }
            }
        }
}

// Returns how far the wall moves outward per metre downward, near the lowest level at which it is known.
double slopeBelow(const Rays& r, int angle, int lowest) {
    const int levels = std::max(2, int(kSlopeOver_m / r.grid.spacing_m.z));
    double sum = 0.0;
    int count = 0;
    for (int a = angle - 6; a <= angle + 6; ++a) {
        if (lowest + levels >= r.grid.dims.z) continue;
        const double low_m = r.wall_m[r.at(a, lowest)], high_m = r.wall_m[r.at(a, lowest + levels)];
        if (low_m > 0.0 && high_m > 0.0) sum += (low_m - high_m) / (levels * r.grid.spacing_m.z), ++count;
    }
    return count > 0 ? std::clamp(sum / count, -kMaxSlope, kMaxSlope) : 0.0;
}

// Returns true if the angle points towards the mediastinum: there are no ribs behind the lung, apart from an
// occasional calcified node.
bool isOpen(const Rays& r, int angle) {
    int levels = 0, with_lung = 0;
    for (int a = angle - kAround; a <= angle + kAround; ++a)
        for (int z = 0; z < r.grid.dims.z; ++z) {
            const std::size_t at = r.at(a, z);
            levels += r.wall_m[at] > 0.0;
            with_lung += r.lung_m[at] > 0.0 && !reachesEdge(r, at);
        }
    return levels == 0 || levels < kClosedShare * with_lung;
}

// Sets the wall at every angle and level. Works from the head down and extrapolates the last known level to
// unknown levels.
void completeWall(Rays& r) {
    const Rays known = r;
    for (int a = 0; a < kAngles; ++a) {
        const bool open = isOpen(known, a);
        int last = r.grid.dims.z - 1;  // level where the wall was last known; -1: outside the image
        while (last >= 0 && known.wall_m[r.at(a, last)] <= 0.0 && !reachesEdge(r, r.at(a, last)))
            --last;
        if (last >= 0 && known.wall_m[r.at(a, last)] <= 0.0) last = -1;
        double slope = 0.0;
        for (int z = r.grid.dims.z - 1; z >= 0; --z) {
            const std::size_t at = r.at(a, z);
            if (known.wall_m[at] > 0.0) last = z, slope = slopeBelow(known, a, z);
            if (reachesEdge(r, at)) last = -1;
            r.open[at] = open || last < 0;
            if (r.open[at])
                r.wall_m[at] = r.edge_m[at] + kBeyondEdge_m;
            else
                r.wall_m[at] =
                    known.wall_m[r.at(a, last)] + slope * std::max(0, last - z) * r.grid.spacing_m.z;
        }
    }
}

void smoothWall(Rays& r) {
    constexpr int kReach = 3;
    const std::vector<double> old_m = r.wall_m;
    for (int z = 0; z < r.grid.dims.z; ++z)
        for (int a = 0; a < kAngles; ++a) {
            double sum = 0.0;
            int count = 0;
            for (int k = std::max(0, z - kReach); k <= std::min(r.grid.dims.z - 1, z + kReach); ++k)
                for (int b = a - kReach; b <= a + kReach; ++b)
                    sum += old_m[r.at(b, k)], ++count;
            double wall_m = sum / count;
            const double bone_m = r.bone_m[r.at(a, z)];
            if (!r.open[r.at(a, z)] && bone_m < 1e2 && bone_m > 0.6 * wall_m)
                wall_m = std::min(wall_m, bone_m - kBeforeBone_m);
            r.wall_m[r.at(a, z)] = wall_m;
        }
}

double wallAt(const Rays& r, double phi, int z) {
    const double at = phi * kAngles / (2.0 * std::numbers::pi), low = std::floor(at);
    const double f = at - low;
    return (1.0 - f) * r.wall_m[r.at(int(low), z)] + f * r.wall_m[r.at(int(low) + 1, z)];
}

}  // namespace

Mask chestCavity(const std::vector<Phase>& phases) {
    const Mask lung = airOfAnyPhase(phases);
    Mask bone = averageBone(phases);
    Rays rays = castRays(lung, bone);
    findWall(rays);
    completeWall(rays);
    smoothWall(rays);

    // Keep the spine only. Calcifications in the lung move with the lung.
    keepLargestComponent(bone);
    const FloatVolume to_spine = distanceTo(bone);
    Mask cavity(lung.grid);
    parallelVoxels(cavity.grid, [&](const Index3& i) {
        const Vec3 p = cavity.grid.centre(i);
        const double dx = p.x - rays.x_m, dy = p.y - rays.y_m;
        const double phi = std::atan2(dy, dx) + (dy < 0.0 ? 2.0 * std::numbers::pi : 0.0);
        cavity[i] = std::hypot(dx, dy) < wallAt(rays, phi, i.z) && double(to_spine[i]) > kAroundSpine_m;
    });
    keepLargestComponent(cavity);
    return cavity;
}

FloatVolume signedDistance(const Mask& mask) {
    FloatVolume level = distanceTo(mask);
    const FloatVolume depth = distanceTo(inverted(mask));
    const auto half =
        float(0.5 * std::min({mask.grid.spacing_m.x, mask.grid.spacing_m.y, mask.grid.spacing_m.z}));
    for (std::size_t i = 0; i < level.voxels.size(); ++i)
        level.voxels[i] = mask.voxels[i] ? half - depth.voxels[i] : level.voxels[i] - half;
    return level;
}

}  // namespace stylet::modeller
