// The volume that the rays sample, on the GPU: the patient's attenuation. Contrast is written into the
// volume when it changes, so it costs the rays nothing.
#pragma once

#include "patient/contrast/contrast.h"
#include "render/fluoroscopy/attenuation.h"
#include "render/gpu/memory.h"

namespace stylet::render {

class TissueImage {
  public:
    explicit TissueImage(const Gpu& gpu) : gpu_(&gpu) {}

    // Returns true if the images are new. `margin_m`: as in makeCellGrid().
    bool prepare(const CtVolume&, double voxel_m, double margin_m);
    // Writes the contrast if the table, its revision or the volume has changed, or if `always`. Null or
    // empty: no contrast. Returns true if it was written.
    bool show(const patient::ContrastTable*, bool always);
    void recordUpload(const vk::raii::CommandBuffer&);

    const Grid& grid() const { return base_.grid; }
    const Grid& cellGrid() const { return cells_.grid; }
    const GpuImage& tissue() const { return tissue_; }      // R16F, relative to water
    const GpuImage& cells() const { return cells_image_; }  // R8_UINT: 0 where nothing attenuates

  private:
    struct Region {
        Index3 low{0}, high{0};  // [low, high)
        bool empty() const { return glm::any(glm::lessThanEqual(high, low)); }
        friend bool operator==(const Region&, const Region&) = default;
    };
    // Part of a texture that the next commands rewrite.
    struct Upload {
        Buffer staging;
        Region region;
        bool stale = false;
    };
    Region contrastRegion(const patient::ContrastTable&) const;
    void compose(const patient::ContrastTable*, const Region&);
    void markCells(const Region&);
    void reserve(Upload&, const Region&, std::size_t bytes_per_texel);
    static void record(const vk::raii::CommandBuffer&, const GpuImage&, Upload&);

    const Gpu* gpu_;
    AttenuationVolume base_;  // without contrast
    CellGrid cells_;
    GpuImage tissue_, cells_image_;
    Upload tissue_upload_, cells_upload_;
    double voxel_m_ = 0.0, margin_m_ = 0.0;
    const patient::ContrastTable* shown_ = nullptr;
    std::uint64_t revision_ = 0;
    bool stale_ = true;
    Region written_;  // where there may be contrast now
};

}  // namespace stylet::render
