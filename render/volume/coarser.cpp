#include "render/volume/coarser.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace stylet::render {
namespace {

constexpr double kThinShare = 0.25;

struct Block {
    double hu_sum = 0.0;
    int voxels = 0;
    std::array<int, 256> labels{};
};

Block blockAt(const patient::Package& package, const Index3& first, int factor) {
    Block block;
    const Index3 end = glm::min(first + factor, package.ct.grid.dims);
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x) {
                block.hu_sum += double(package.ct[{x, y, z}]);
                ++block.labels[package.labels[{x, y, z}]];
                ++block.voxels;
            }
    return block;
}

std::uint8_t labelOf(const Block& block, const std::vector<std::uint8_t>& thin) {
    for (const std::uint8_t id : thin)
        if (block.labels[id] >= kThinShare * block.voxels) return id;
    return std::uint8_t(std::max_element(block.labels.begin(), block.labels.end()) - block.labels.begin());
}

}  // namespace

patient::Package coarser(const patient::Package& package, int factor) {
    assert(factor >= 1);
    const Grid& fine = package.ct.grid;
    Grid grid;
    grid.dims = (fine.dims + (factor - 1)) / factor;
    grid.spacing_m = fine.spacing_m * double(factor);
    // The grid's origin is the centre of a voxel.
    grid.origin_m = fine.origin_m + 0.5 * (factor - 1) * fine.spacing_m;
    std::vector<std::uint8_t> thin;
    for (const patient::Tissue tissue : {patient::Tissue::duct, patient::Tissue::vessel})
        for (const patient::Label& label : package.label_table)
            if (label.tissue == tissue) thin.push_back(label.id);
    patient::Package out;
    out.name = package.name, out.licence = package.licence, out.provenance = package.provenance;
    out.tissues = package.tissues, out.elasticity = package.elasticity, out.thresholds = package.thresholds;
    out.label_table = package.label_table, out.motion = package.motion;
    out.ct = CtVolume(grid);
    out.labels = LabelVolume(grid);
    for (int z = 0; z < grid.dims.z; ++z)
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x) {
                const Block block = blockAt(package, Index3(x, y, z) * factor, factor);
                out.ct[{x, y, z}] = std::int16_t(std::lround(block.hu_sum / block.voxels));
                out.labels[{x, y, z}] = labelOf(block, thin);
            }
    return out;
}

}  // namespace stylet::render
