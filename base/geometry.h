// Points, rigid transforms and voxel grids. All lengths in metres, double precision.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace stylet {

using Vec3 = glm::dvec3;
using Quat = glm::dquat;
using Index3 = glm::ivec3;

inline bool isFinite(const Vec3& v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// A rigid transform a_from_b: `p_a = a_from_b * p_b`. The rotation is a unit quaternion.
struct Pose {
    Quat rotation{1.0, 0.0, 0.0, 0.0};
    Vec3 position_m{0.0};

    Vec3 operator*(const Vec3& p) const noexcept { return rotation * p + position_m; }
    Pose operator*(const Pose& c_from_b) const noexcept {
        return {rotation * c_from_b.rotation, rotation * c_from_b.position_m + position_m};
    }
    Vec3 direction(const Vec3& d) const noexcept { return rotation * d; }
    Pose inverse() const noexcept {
        const Quat back = glm::conjugate(rotation);
        return {back, back * -position_m};
    }
};
inline bool isFinite(const Pose& p) noexcept {
    const Quat& q = p.rotation;
    return isFinite(p.position_m) && std::isfinite(q.w) && isFinite(Vec3(q.x, q.y, q.z));
}

// An axis-aligned voxel grid in the patient frame (RAS: x grows to the patient's right, y to the front,
// z to the head). Voxel (0,0,0) has its CENTRE at `origin_m`.
struct Grid {
    Index3 dims{0};
    Vec3 spacing_m{0.001};
    Vec3 origin_m{0.0};

    std::size_t voxelCount() const noexcept {
        return std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z);
    }
    bool contains(const Index3& i) const noexcept {
        return i.x >= 0 && i.y >= 0 && i.z >= 0 && i.x < dims.x && i.y < dims.y && i.z < dims.z;
    }
    // atBorder() is true for the outermost voxels, atSide() for those at the right, left, front and back.
    bool atSide(const Index3& i) const noexcept {
        return i.x == 0 || i.y == 0 || i.x == dims.x - 1 || i.y == dims.y - 1;
    }
    bool atBorder(const Index3& i) const noexcept { return atSide(i) || i.z == 0 || i.z == dims.z - 1; }
    std::size_t offset(const Index3& i) const noexcept {
        return (std::size_t(i.z) * std::size_t(dims.y) + std::size_t(i.y)) * std::size_t(dims.x) +
               std::size_t(i.x);
    }
    // Offset between neighbours along each axis.
    std::array<std::size_t, 3> strides() const noexcept {
        return {1, std::size_t(dims.x), std::size_t(dims.x) * std::size_t(dims.y)};
    }
    // The voxel at an offset: the inverse of offset().
    Index3 voxelAt(std::size_t offset) const noexcept {
        const auto nx = std::size_t(dims.x), ny = std::size_t(dims.y);
        return {int(offset % nx), int(offset / nx % ny), int(offset / (nx * ny))};
    }
    Vec3 centre(const Index3& i) const noexcept { return origin_m + spacing_m * Vec3(i); }
    // Continuous voxel coordinates: integer at voxel centres.
    Vec3 toVoxels(const Vec3& p) const noexcept { return (p - origin_m) / spacing_m; }
    // The voxel whose cell contains p; may lie outside the grid. |p| must be below 1000 km.
    Index3 nearest(const Vec3& p) const noexcept {
        const Vec3 v = toVoxels(p);
        return {int(std::floor(v.x + 0.5)), int(std::floor(v.y + 0.5)), int(std::floor(v.z + 0.5))};
    }
    friend bool operator==(const Grid&, const Grid&) = default;
};

// Visits the voxels from `low` to `high`, both included, in memory order.
template <typename Visit>
void forEachVoxel(const Index3& low, const Index3& high, const Visit& visit) {
    Index3 i;
    for (i.z = low.z; i.z <= high.z; ++i.z)
        for (i.y = low.y; i.y <= high.y; ++i.y)
            for (i.x = low.x; i.x <= high.x; ++i.x)
                visit(i);
}
template <typename Visit>
void forEachVoxel(const Grid& grid, const Visit& visit) {
    forEachVoxel(Index3(0), grid.dims - 1, visit);
}

}  // namespace stylet
