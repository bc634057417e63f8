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

// Adds the voxels with at least `least` of their six neighbours in the mask, if `may(voxel)` is true.
template <typename May>
void addBeside(Mask& mask, int least, May may) {
    const Mask old = mask;
    const Index3 n = mask.grid.dims;
    for (int z = 1; z + 1 < n.z; ++z)
        for (int y = 1; y + 1 < n.y; ++y)
            for (int x = 1; x + 1 < n.x; ++x) {
                if (old[{x, y, z}] || !may(Index3{x, y, z})) continue;
                const int around = old[{x - 1, y, z}] + old[{x + 1, y, z}] + old[{x, y - 1, z}] +
                                   old[{x, y + 1, z}] + old[{x, y, z - 1}] + old[{x, y, z + 1}];
                if (around >= least) mask[{x, y, z}] = 1;
            }
}

}  // namespace

Mask bodyMask(const CtVolume& ct) {
    Mask dense(ct.grid);
    for (std::size_t i = 0; i < dense.voxels.size(); ++i)
        dense.voxels[i] = ct.voxels[i] > kBodyAbove_hu;
    addBeside(dense, 5, [](const Index3&) { return true; });  // single dark voxels are noise
    const FloatVolume depth = distanceTo(inverted(dense));
    Mask core(ct.grid);
    for (std::size_t i = 0; i < core.voxels.size(); ++i)
        core.voxels[i] = depth.voxels[i] > kOpening_m;
    keepLargest(core);
    const FloatVolume from_core = distanceTo(core);
    for (std::size_t i = 0; i < dense.voxels.size(); ++i)
        dense.voxels[i] = dense.voxels[i] && from_core.voxels[i] < kOpening_m;
    keepLargest(dense);
    addBeside(dense, 1, [&](const Index3& i) { return ct[i] > kSurface_hu; });
    fillHolesPerSlice(dense);
    return dense;
}

Mask skinShell(const Mask& body, const Grid& scanned, double thickness_m) {
    const Grid& g = body.grid;
    Mask air(g);
    const Vec3 low = scanned.origin_m, high = scanned.centre(scanned.dims - 1);
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                const Vec3 p = g.centre(i);
                const bool seen = p.x > low.x && p.y > low.y && p.x < high.x && p.y < high.y;
                air[i] = seen && !body[i];
            }
    const FloatVolume depth = distanceTo(air);
    // `depth` is measured from the centre of the nearest air voxel. That centre is half a voxel outside the
    // skin surface, so half a voxel is added to the thickness. The shell is at least one voxel thick.
    const double voxel_m = std::max({g.spacing_m.x, g.spacing_m.y, g.spacing_m.z});
    const double reach_m = std::max(thickness_m + 0.5 * voxel_m, 1.01 * voxel_m);
    Mask skin(g);
    for (std::size_t i = 0; i < skin.voxels.size(); ++i)
        skin.voxels[i] = body.voxels[i] && double(depth.voxels[i]) <= reach_m;
    return skin;
}

}  // namespace stylet::modeller
