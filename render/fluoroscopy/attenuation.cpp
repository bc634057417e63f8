#include "render/fluoroscopy/attenuation.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/packing.hpp>

namespace stylet::render {
namespace {

Grid coarseGrid(const Grid& fine, double voxel_m) {
    Grid grid = fine;
    for (int axis = 0; axis < 3; ++axis) {
        const double extent_m = fine.dims[axis] * fine.spacing_m[axis];
        grid.dims[axis] = std::clamp(int(std::lround(extent_m / voxel_m)), 2, fine.dims[axis]);
        grid.spacing_m[axis] = extent_m / grid.dims[axis];
        grid.origin_m[axis] = fine.origin_m[axis] + 0.5 * (grid.spacing_m[axis] - fine.spacing_m[axis]);
    }
    return grid;
}

}  // namespace

AttenuationVolume computeAttenuation(const CtVolume& ct, double voxel_m, int threads) {
    AttenuationVolume volume;
    volume.grid = coarseGrid(ct.grid, voxel_m);
    const Index3 dims = volume.grid.dims;
    volume.half.resize(volume.grid.voxelCount());
    const auto along_x = computeResampleWeights(ct.grid, volume.grid, 0, 0, dims.x),
               along_y = computeResampleWeights(ct.grid, volume.grid, 1, 0, dims.y),
               along_z = computeResampleWeights(ct.grid, volume.grid, 2, 0, dims.z);
    parallelFor(threads, std::size_t(dims.z), [&](std::size_t z) {
        std::vector<float> fine(std::size_t(ct.grid.dims.x)),
            plane(std::size_t(dims.x) * std::size_t(dims.y), 0.0f);
        for (std::size_t k = 0; k < along_z[z].weights.size(); ++k)
            for (std::size_t y = 0; y < along_y.size(); ++y)
                for (std::size_t j = 0; j < along_y[y].weights.size(); ++j) {
                    const float weight = along_z[z].weights[k] * along_y[y].weights[j];
                    const std::size_t row =
                        ct.grid.offset({0, along_y[y].first + int(j), along_z[z].first + int(k)});
                    for (std::size_t x = 0; x < fine.size(); ++x)
                        fine[x] = float(relativeAttenuation(double(ct.voxels[row + x])));
                    for (std::size_t x = 0; x < along_x.size(); ++x) {
                        float sum = 0.0f;
                        for (std::size_t i = 0; i < along_x[x].weights.size(); ++i)
                            sum += along_x[x].weights[i] * fine[std::size_t(along_x[x].first) + i];
                        plane[y * along_x.size() + x] += weight * sum;
                    }
                }
        std::transform(plane.begin(), plane.end(), volume.half.begin() + std::ptrdiff_t(z * plane.size()),
                       [](float v) { return glm::packHalf1x16(v); });
    });
    return volume;
}

CellGrid makeCellGrid(const AttenuationVolume& volume, double cell_m, double margin_m) {
    const Grid& voxels = volume.grid;
    CellGrid cells{coarseGrid(voxels, cell_m), {}};
    const Index3 dims = cells.grid.dims;
    std::vector<std::uint8_t> own(cells.grid.voxelCount(), 0);
    std::vector<int> cell_of_x(std::size_t(voxels.dims.x));
    const auto toCell = [&](int voxel, int axis) {
        return std::min(int((voxel + 0.5) * dims[axis] / voxels.dims[axis]), dims[axis] - 1);
    };
    for (int x = 0; x < voxels.dims.x; ++x)
        cell_of_x[std::size_t(x)] = toCell(x, 0);
    for (int z = 0; z < voxels.dims.z; ++z)
        for (int y = 0; y < voxels.dims.y; ++y) {
            std::uint8_t* const row = &own[cells.grid.offset({0, toCell(y, 1), toCell(z, 2)})];
            std::size_t at = voxels.offset({0, y, z});
            for (int x = 0; x < voxels.dims.x; ++x, ++at)
                if (volume.half[at] != 0) row[cell_of_x[std::size_t(x)]] = 1;
        }
    // A sample also reads the neighbouring voxels.
    for (int axis = 0; axis < 3; ++axis) {
        const int reach = int(std::ceil((margin_m + voxels.spacing_m[axis]) / cells.grid.spacing_m[axis]));
        const std::size_t stride = axis == 0   ? 1
                                   : axis == 1 ? std::size_t(dims.x)
                                               : std::size_t(dims.x) * std::size_t(dims.y);
        cells.occupied.assign(own.size(), 0);
        for (std::size_t i = 0; i < own.size(); ++i) {
            if (!own[i]) continue;
            const int at = int(i / stride) % dims[axis];
            for (int k = std::max(-reach, -at); k <= std::min(reach, dims[axis] - 1 - at); ++k)
                cells.occupied[std::size_t(std::ptrdiff_t(i) + k * std::ptrdiff_t(stride))] = 1;
        }
        own = cells.occupied;
    }
    return cells;
}

std::vector<ResampleWeights> computeResampleWeights(const Grid& from, const Grid& to, int axis, int low,
                                                    int high) {
    std::vector<ResampleWeights> covers(std::size_t(high - low));
    const double ratio = to.spacing_m[axis] / from.spacing_m[axis];
    const double begin = (to.origin_m[axis] - from.origin_m[axis]) / from.spacing_m[axis] - 0.5 * ratio + 0.5;
    for (int i = low; i < high; ++i) {
        const double from_low = std::max(begin + i * ratio, 0.0), from_high = begin + (i + 1) * ratio;
        ResampleWeights& cover = covers[std::size_t(i - low)];
        cover.first = int(std::floor(from_low + 1e-6));
        for (int k = cover.first; k < from.dims[axis] && k < from_high - 1e-6; ++k)
            cover.weights.push_back(
                float((std::min(from_high, k + 1.0) - std::max(from_low, double(k))) / ratio));
    }
    return covers;
}

}  // namespace stylet::render
