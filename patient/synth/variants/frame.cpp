#include "patient/synth/variants/frame.h"

#include <algorithm>
#include <cmath>

namespace stylet::patient::synth {

namespace {

struct Section {
    Index3 low, high;  // both inclusive
};

template <typename T>
void crop(Volume<T>& volume, const Section& kept) {
    const Grid& grid = volume.grid;
    Volume<T> part(Grid{kept.high - kept.low + 1, grid.spacing_m, grid.centre(kept.low)});
    forEachVoxel(part.grid, [&](const Index3& i) { part[i] = volume[kept.low + i]; });
    volume = std::move(part);
}

void crop(Package& p, const Section& kept) {
    crop(p.ct, kept);
    crop(p.labels, kept);
}

Section whole(const Package& p) {
    return {Index3(0), p.ct.grid.dims - 1};
}

// Bounding box of the voxels for which `in` is true.
template <typename In>
Section bounds(const Package& p, const In& in) {
    Section box{p.labels.grid.dims, Index3(-1)};
    forEachVoxel(p.labels.grid, [&](const Index3& i) {
        if (in(p.labels[i])) box.low = glm::min(box.low, i), box.high = glm::max(box.high, i);
    });
    return box;
}

Section liverBounds(const Package& p) {
    std::array<bool, 256> liver{};
    for (const Label& l : p.label_table)
        liver[l.id] = l.tissue == Tissue::liver && l.structure != Structure::tumour;
    return bounds(p, [&](std::uint8_t id) { return liver[id]; });
}

int voxels(double m, double spacing_m) {
    return int(std::lround(m / spacing_m));
}

template <typename T>
void reverse(Volume<T>& volume, bool x, bool y, bool z) {
    const Volume<T> old = volume;
    const Index3 last = volume.grid.dims - 1;
    forEachVoxel(volume.grid, [&](const Index3& i) {
        volume[i] = old[Index3{x ? last.x - i.x : i.x, y ? last.y - i.y : i.y, z ? last.z - i.z : i.z}];
    });
}

void removeMotion(Package& p) {
    MotionModel none;
    none.reference = p.motion.reference;
    p.motion = std::move(none);
}

}  // namespace

void cutRight(Package& p, double depth_m) {
    Section kept = whole(p);
    kept.high.x =
        bounds(p, [](std::uint8_t id) { return id != 0; }).high.x - voxels(depth_m, p.ct.grid.spacing_m.x);
    crop(p, kept);
}

void cutTop(Package& p, double depth_m) {
    Section kept = whole(p);
    kept.high.z = liverBounds(p).high.z - voxels(depth_m, p.ct.grid.spacing_m.z);
    crop(p, kept);
}

void cutBottom(Package& p, double depth_m) {
    Section kept = whole(p);
    kept.low.z = liverBounds(p).low.z + voxels(depth_m, p.ct.grid.spacing_m.z);
    crop(p, kept);
}

void reverse(Package& p, bool x, bool y, bool z) {
    reverse(p.ct, x, y, z);
    reverse(p.labels, x, y, z);
    removeMotion(p);
}

void misstateSpacing(Package& p, double factor) {
    for (Grid* grid : {&p.ct.grid, &p.labels.grid})
        grid->spacing_m.z *= factor;
    removeMotion(p);
}

void shiftHu(Package& p, int hu) {
    for (std::int16_t& value : p.ct.voxels)
        value = std::int16_t(std::min(int(value) + hu, 3071));
}

}  // namespace stylet::patient::synth
