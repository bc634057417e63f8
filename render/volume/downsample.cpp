#include "render/volume/downsample.h"

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
    forEachVoxel({end - first}, [&](const Index3& i) {
        block.hu_sum += double(package.ct[first + i]);
        ++block.labels[package.labels[first + i]];
        ++block.voxels;
    });
    return block;
}

std::uint8_t chooseLabel(const Block& block, const std::vector<std::uint8_t>& thin) {
    for (const std::uint8_t id : thin)
        if (block.labels[id] >= kThinShare * block.voxels) return id;
    return std::uint8_t(std::max_element(block.labels.begin(), block.labels.end()) - block.labels.begin());
}

}  // namespace

patient::Package downsample(const patient::Package& package, int factor) {
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
    out.atlases = package.atlases;
    out.tissues = package.tissues, out.elasticity = package.elasticity, out.thresholds = package.thresholds;
    out.label_table = package.label_table, out.motion = package.motion;
    out.ct = CtVolume(grid);
    out.labels = LabelVolume(grid);
    forEachVoxel(grid, [&](const Index3& i) {
        const Block block = blockAt(package, i * factor, factor);
        out.ct[i] = std::int16_t(std::lround(block.hu_sum / block.voxels));
        out.labels[i] = chooseLabel(block, thin);
    });
    return out;
}

}  // namespace stylet::render
