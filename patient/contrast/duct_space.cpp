#include "patient/contrast/duct_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/distance.h"

namespace stylet::patient {

namespace {

bool isTargetDuct(const Label* label) {
    return label && label->tissue == Tissue::duct && label->role == Role::target;
}

// Box around all target ducts with a margin of kFarFromDucts_m, within the patient's grid. No voxels without
// ducts.
Grid boxAroundDucts(const Patient& patient) {
    const Grid& whole = patient.grid();
    Index3 low = whole.dims, high(-1);
    const LabelVolume& labels = patient.package().labels;
    forEachVoxel(whole, [&](const Index3& i) {
        if (!isTargetDuct(patient.label(labels[i]))) return;
        low = glm::min(low, i);
        high = glm::max(high, i);
    });
    if (high.x < 0) return {};
    const Index3 margin = Index3(glm::ceil(Vec3(kFarFromDucts_m) / whole.spacing_m)) + 1;
    low = glm::max(low - margin, Index3(0));
    high = glm::min(high + margin, whole.dims - 1);
    return {high - low + 1, whole.spacing_m, whole.centre(low)};
}

}  // namespace

DuctSpace makeDuctSpace(const Patient& patient, int threads) {
    DuctSpace space;
    const Grid box = boxAroundDucts(patient);
    if (box.voxelCount() == 0) return space;
    const LabelVolume& labels = patient.package().labels;
    const Index3 low = patient.grid().nearest(box.origin_m);
    Volume<std::uint8_t> lumen(box), tissue(box);
    forEachVoxel(box, [&](const Index3& i) {
        lumen[i] = std::uint8_t(isTargetDuct(patient.label(labels[i + low])));
        tissue[i] = std::uint8_t(lumen[i] == 0);
    });
    const Volume<float> outside = distanceTo(lumen, Sites::all, threads);
    const Volume<float> inside = distanceTo(tissue, Sites::all, threads);
    // Distances are between voxel centres, and the wall lies halfway between two of them. Beyond it the wall
    // yields by half a voxel, or a duct as thin as a voxel would be closed where it runs diagonally.
    const auto half = 0.5f * float(std::min({box.spacing_m.x, box.spacing_m.y, box.spacing_m.z}));
    const auto far = float(kFarFromDucts_m);
    space.level_m = Volume<float>(box);
    for (std::size_t i = 0; i < space.level_m.voxels.size(); ++i)
        space.level_m.voxels[i] = lumen.voxels[i] != 0 ? std::max(-inside.voxels[i], -far)
                                                       : std::min(outside.voxels[i] - 2.0f * half, far);
    return space;
}

namespace {

double mix(double a, double b, double share) noexcept {
    return a + share * (b - a);
}

// The cell around a point, and the level interpolated in it: along x on its four edges, then along y, then
// along z.
struct Interpolated {
    const float* c = nullptr;  // the cell's first corner; null: outside the grid
    Vec3 t;                    // place in the cell, 0 to 1
    std::array<double, 4> edge;
    double low, high;

    Interpolated(const Volume<float>& level, const Vec3& reference_m) noexcept {
        const Grid& grid = level.grid;
        const Vec3 at = grid.toVoxels(reference_m);
        // False for NaN, and for an empty grid.
        const bool within = at.x >= 0.0 && at.y >= 0.0 && at.z >= 0.0 && at.x < grid.dims.x - 1 &&
                            at.y < grid.dims.y - 1 && at.z < grid.dims.z - 1;
        if (!within) return;
        const Index3 cell(at);
        t = at - Vec3(cell);
        const auto [sx, sy, sz] = grid.strides();
        c = level.voxels.data() + grid.offset(cell);
        edge = {mix(c[0], c[sx], t.x), mix(c[sy], c[sx + sy], t.x), mix(c[sz], c[sx + sz], t.x),
                mix(c[sy + sz], c[sx + sy + sz], t.x)};
        low = mix(edge[0], edge[1], t.y), high = mix(edge[2], edge[3], t.y);
    }
    double value() const noexcept { return c ? mix(low, high, t.z) : kFarFromDucts_m; }
};

}  // namespace

double ductLevelAt(const DuctSpace& space, const Vec3& reference_m) noexcept {
    return Interpolated(space.level_m, reference_m).value();
}

DuctWall ductWallAt(const DuctSpace& space, const Vec3& reference_m) noexcept {
    const Interpolated in(space.level_m, reference_m);
    if (!in.c) return {in.value(), Vec3(0.0)};
    const Grid& grid = space.level_m.grid;
    const auto [sx, sy, sz] = grid.strides();
    const auto& [c, t, edge, low, high] = in;
    const double x0 = mix(c[sx] - c[0], c[sx + sy] - c[sy], t.y);
    const double x1 = mix(c[sx + sz] - c[sz], c[sx + sy + sz] - c[sy + sz], t.y);
    const Vec3 slope =
        Vec3(mix(x0, x1, t.z), mix(edge[1] - edge[0], edge[3] - edge[2], t.z), high - low) / grid.spacing_m;
    const double length = std::sqrt(glm::dot(slope, slope));
    return {in.value(), length > 1e-6 ? slope / length : Vec3(0.0)};
}

}  // namespace stylet::patient
