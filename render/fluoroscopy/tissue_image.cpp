#include "render/fluoroscopy/tissue_image.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/gtc/packing.hpp>

#include "base/parallel.h"
#include "render/gpu/image_states.h"

namespace stylet::render {
namespace {

constexpr double kCell_m = 0.008;

}  // namespace

bool TissueImage::prepare(const CtVolume& ct, double voxel_m, double margin_m) {
    const bool other_volume = voxel_m_ != voxel_m;
    if (!other_volume && margin_m_ == margin_m) return false;
    if (other_volume) {
        base_ = computeAttenuation(ct, voxel_m, std::max(2, processorCount() / 2));
        tissue_ = makeFilledVolume(*gpu_, vk::Format::eR16Sfloat, base_.grid.dims, sizeof(std::uint16_t),
                                   base_.half.data());
        tissue_upload_.stale = false;
        written_ = {};
    }
    cells_ = makeCellGrid(base_, kCell_m, margin_m);
    cells_image_ = makeFilledVolume(*gpu_, vk::Format::eR8Uint, cells_.grid.dims, 1, cells_.occupied.data());
    cells_upload_.stale = false;
    stale_ = true;
    voxel_m_ = voxel_m;
    margin_m_ = margin_m;
    return true;
}

TissueImage::Region TissueImage::contrastRegion(const patient::ContrastTable& table) const {
    const Vec3 half = 0.5 * table.grid.spacing_m;
    const Vec3 low = base_.grid.toVoxels(table.grid.origin_m - half) + 0.5;
    const Vec3 high = base_.grid.toVoxels(table.grid.centre(table.grid.dims - 1) + half) + 0.5;
    return {glm::clamp(Index3(glm::floor(low + 1e-6)), Index3(0), base_.grid.dims),
            glm::clamp(Index3(glm::ceil(high - 1e-6)), Index3(0), base_.grid.dims)};
}

bool TissueImage::show(const patient::ContrastTable* table, bool always) {
    if (table && table->added_per_m.empty()) table = nullptr;
    const bool same = !stale_ && shown_ == table && (!table || revision_ == table->revision);
    if (same && !always) return false;
    const Region now = table ? contrastRegion(*table) : Region{};
    // Includes the region where contrast was before.
    Region region = now;
    if (!written_.empty())
        region = now.empty() ? written_
                             : Region{glm::min(now.low, written_.low), glm::max(now.high, written_.high)};
    if (!region.empty()) {
        compose(table, region);
        markCells(now);
    }
    written_ = now;
    shown_ = table;
    revision_ = table ? table->revision : 0;
    stale_ = false;
    return !region.empty();
}

void TissueImage::reserve(Upload& upload, const Region& region, std::size_t bytes_per_texel) {
    const vk::DeviceSize bytes = Grid{region.high - region.low}.voxelCount() * bytes_per_texel;
    if (upload.staging.size < bytes)
        upload.staging = Buffer(*gpu_, bytes, vk::BufferUsageFlagBits::eTransferSrc);
    upload.region = region;
    upload.stale = true;
}

// Writes the tissue of a region, plus the mean of the contrast in each voxel.
void TissueImage::compose(const patient::ContrastTable* table, const Region& region) {
    reserve(tissue_upload_, region, sizeof(std::uint16_t));
    auto* const out = static_cast<std::uint16_t*>(tissue_upload_.staging.mapped);
    const Index3 dims = region.high - region.low;
    std::array<std::vector<ResampleWeights>, 3> covers;
    if (table)
        for (int axis = 0; axis < 3; ++axis)
            covers[std::size_t(axis)] =
                computeResampleWeights(table->grid, base_.grid, axis, region.low[axis], region.high[axis]);
    std::vector<float> added(table ? std::size_t(table->grid.dims.x) : 0);
    for (int z = 0; z < dims.z; ++z)
        for (int y = 0; y < dims.y; ++y) {
            const std::size_t from = base_.grid.offset(region.low + Index3(0, y, z));
            std::uint16_t* const row =
                out + (std::size_t(z) * std::size_t(dims.y) + std::size_t(y)) * std::size_t(dims.x);
            std::copy_n(&base_.half[from], dims.x, row);
            if (!table) continue;
            const ResampleWeights &in_z = covers[2][std::size_t(z)], &in_y = covers[1][std::size_t(y)];
            std::fill(added.begin(), added.end(), 0.0f);
            bool any = false;
            for (std::size_t k = 0; k < in_z.weights.size(); ++k)
                for (std::size_t j = 0; j < in_y.weights.size(); ++j) {
                    const float weight = in_z.weights[k] * in_y.weights[j] / float(kWaterPerM);
                    const float* const values =
                        &table
                             ->added_per_m[table->grid.offset({0, in_y.first + int(j), in_z.first + int(k)})];
                    for (std::size_t x = 0; x < added.size(); ++x)
                        added[x] += weight * values[x], any |= values[x] != 0.0f;
                }
            for (int x = 0; any && x < dims.x; ++x) {
                const ResampleWeights& in_x = covers[0][std::size_t(x)];
                float sum = 0.0f;
                for (std::size_t i = 0; i < in_x.weights.size(); ++i)
                    sum += in_x.weights[i] * added[std::size_t(in_x.first) + i];
                if (sum != 0.0f) row[x] = glm::packHalf1x16(glm::unpackHalf1x16(row[x]) + sum);
            }
        }
}

// Marks all cells in reach of the contrast's box as occupied: contrast in air must not be skipped.
void TissueImage::markCells(const Region& region) {
    const Region all{Index3(0), cells_.grid.dims};
    reserve(cells_upload_, all, 1);
    auto* const out = static_cast<std::uint8_t*>(cells_upload_.staging.mapped);
    std::memcpy(out, cells_.occupied.data(), cells_.occupied.size());
    if (region.empty()) return;
    const Vec3 reach = margin_m_ + base_.grid.spacing_m;
    const Index3 low = glm::max(cells_.grid.nearest(base_.grid.centre(region.low) - reach), Index3(0));
    const Index3 high =
        glm::min(cells_.grid.nearest(base_.grid.centre(region.high - 1) + reach), cells_.grid.dims - 1);
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            std::fill_n(out + cells_.grid.offset({low.x, y, z}), high.x - low.x + 1, std::uint8_t(1));
}

void TissueImage::record(const vk::raii::CommandBuffer& commands, const GpuImage& image, Upload& upload) {
    if (!upload.stale) return;
    const Index3 low = upload.region.low, dims = upload.region.high - low;
    auto part = imagePart({std::uint32_t(dims.x), std::uint32_t(dims.y), std::uint32_t(dims.z)});
    part.imageOffset = vk::Offset3D{low.x, low.y, low.z};
    render::recordUpload(commands, upload.staging, *image.handle, part, kComputeRead, kComputeRead);
    upload.stale = false;
}

void TissueImage::recordUpload(const vk::raii::CommandBuffer& commands) {
    record(commands, tissue_, tissue_upload_);
    record(commands, cells_image_, cells_upload_);
}

}  // namespace stylet::render
