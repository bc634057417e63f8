// Small volumes with boxes, tubes, plates and balls of known size, to test the filters that detect them.
#pragma once

#include <algorithm>
#include <cmath>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::test {

inline Grid cube(int side) {
    return {Index3(side), Vec3(0.001), Vec3(0.0)};
}

// The voxels from `low` to `high`, both included.
inline modeller::Mask box(const Grid& grid, const Index3& low, const Index3& high) {
    modeller::Mask mask(grid);
    forEachVoxel(modeller::VoxelBox{low, high}, [&](const Index3& i) { mask[i] = 1; });
    return mask;
}

// Distance from a point to the segment from a to b [m].
inline double toSegment_m(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 axis = b - a;
    const double t = std::clamp(glm::dot(p - a, axis) / glm::dot(axis, axis), 0.0, 1.0);
    return glm::length(p - a - t * axis);
}

// Share of a voxel (size `spacing_m`) inside a shape of `radius_m`, such as a tube. The voxel centre lies
// `distance_m` from the shape's axis or centre.
inline double coveredShare(double distance_m, double radius_m, double spacing_m) {
    return std::clamp((radius_m - distance_m) / spacing_m + 0.5, 0.0, 1.0);
}

// Noise with a standard deviation of about 1. It depends on the voxel index only.
inline double noiseAt(std::size_t voxel) {
    double sum = 0.0;
    for (std::uint64_t n = 0; n < 4; ++n) {
        std::uint64_t h = (voxel * 4 + n) * 0x9E3779B97F4A7C15ull;
        h = (h ^ (h >> 29)) * 0xBF58476D1CE4E5B9ull;
        sum += double((h ^ (h >> 32)) & 0xFFFFu) / 65535.0 - 0.5;
    }
    return sum * std::sqrt(3.0);
}

// Noisy liver tissue of 112 HU in fat. Tests paint structures into it.
struct LiverPhantom {
    CtVolume ct;
    modeller::Mask mask;

    explicit LiverPhantom(int side, int rim = 6) : ct(cube(side), std::int16_t{-100}), mask(cube(side)) {
        for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
            const Vec3 p = ct.grid.centre(ct.grid.voxelAt(i));
            const double from_border = std::min({p.x, p.y, p.z, 0.001 * (side - 1) - p.x,
                                                 0.001 * (side - 1) - p.y, 0.001 * (side - 1) - p.z});
            mask.voxels[i] = from_border > 0.001 * rim;
            ct.voxels[i] = std::int16_t(std::lround((mask.voxels[i] ? 112.0 : -100.0) + 8.0 * noiseAt(i)));
        }
    }

    // Blends a tube of `hu` into the CT. Returns the voxels that are at least half inside it.
    modeller::Mask tube(const Vec3& a, const Vec3& b, double radius_m, double hu) {
        modeller::Mask inside(ct.grid);
        for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
            const double share =
                coveredShare(toSegment_m(ct.grid.centre(ct.grid.voxelAt(i)), a, b), radius_m, 0.001);
            inside.voxels[i] = share >= 0.5;
            if (share <= 0.0) continue;
            const double old = double(ct.voxels[i]) - 8.0 * noiseAt(i);
            ct.voxels[i] = std::int16_t(std::lround(share * hu + (1.0 - share) * old + 8.0 * noiseAt(i)));
        }
        return inside;
    }
};

}  // namespace stylet::test
