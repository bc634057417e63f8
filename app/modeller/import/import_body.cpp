#include "app/modeller/import/import_body.h"

#include <algorithm>

namespace stylet::modeller {

namespace {

// Denser voxels may belong to the body. The threshold is three standard deviations of the noise below fat,
// so that fat is included. It is above the blurred HU of the gap between the patient's back and the table,
// so that the table stays separate.
constexpr std::int16_t kBodyAbove_hu = -180;
constexpr float kOpening_m = 0.003f;
constexpr std::int16_t kSurface_hu = -500;  // halfway between air and tissue, where a blurred surface lies

// Adds the voxels with at least `min_neighbours` of their six neighbours in the mask, if `may(voxel)` is
// true.
template <typename May>
void addNeighbours(Mask& mask, int min_neighbours, May may) {
    const Mask old = mask;
    forEachVoxel(VoxelBox{Index3(1), mask.grid.dims - 2}, [&](const Index3& i) {
        if (old[i] || !may(i)) return;
        int around = 0;
        forEachNeighbour(old.grid, i, Connectivity::faces, [&](std::size_t o) { around += old.voxels[o]; });
        if (around >= min_neighbours) mask[i] = 1;
    });
}

}  // namespace

Mask bodyMask(const CtVolume& ct) {
    Mask dense = maskWhere(ct.grid, [&](std::size_t i) { return ct.voxels[i] > kBodyAbove_hu; });
    addNeighbours(dense, 5, [](const Index3&) { return true; });  // single dark voxels are noise
    const FloatVolume depth = distanceTo(inverted(dense));
    Mask core = maskWhere(ct.grid, [&](std::size_t i) { return depth.voxels[i] > kOpening_m; });
    keepLargestComponent(core);
    const FloatVolume from_core = distanceTo(core);
    for (std::size_t i = 0; i < dense.voxels.size(); ++i)
        dense.voxels[i] = dense.voxels[i] && from_core.voxels[i] < kOpening_m;
    keepLargestComponent(dense);
    addNeighbours(dense, 1, [&](const Index3& i) { return ct[i] > kSurface_hu; });
    fillHolesPerSlice(dense);
    return dense;
}

Mask skinShell(const Mask& body, const Grid& scanned, double thickness_m) {
    const Grid& g = body.grid;
    Mask air(g);
    const Vec3 low = scanned.origin_m, high = scanned.centre(scanned.dims - 1);
    forEachVoxel(g, [&](const Index3& i) {
        const Vec3 p = g.centre(i);
        const bool seen = p.x > low.x && p.y > low.y && p.x < high.x && p.y < high.y;
        air[i] = seen && !body[i];
    });
    const FloatVolume depth = distanceTo(air);
    // `depth` is measured from the centre of the nearest air voxel. That centre is half a voxel outside the
    // skin surface, so half a voxel is added to the thickness. The shell is at least one voxel thick.
    const double voxel_m = std::max({g.spacing_m.x, g.spacing_m.y, g.spacing_m.z});
    const double reach_m = std::max(thickness_m + 0.5 * voxel_m, 1.01 * voxel_m);
    return maskWhere(g, [&](std::size_t i) { return body.voxels[i] && double(depth.voxels[i]) <= reach_m; });
}

}  // namespace stylet::modeller
