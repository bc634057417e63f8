// The volume layer: what the rays through the patient saw, before it is laid over the opaque things. An image
// an eye of linear premultiplied colour, and one of the depth of the first surface.
#pragma once

#include "render/memory.h"

namespace stylet::render {

class VolumeLayer {
  public:
    explicit VolumeLayer(const Gpu& gpu) : gpu_(&gpu) {}

    // Room for layers of up to this size; true when the images are new.
    bool reserve(vk::Extent2D);

    const GpuImage& colour() const { return colour_; }  // RGBA16F
    const GpuImage& depth() const { return depth_; }    // R32F, m along the eye's -z; 0 = nothing that hides

    // Fills them from tightly packed texels, eye after eye.
    void upload(const vk::raii::CommandBuffer&, const Buffer& colour, const Buffer& depth,
                vk::Extent2D) const;
    // Nothing was seen.
    void clear(const vk::raii::CommandBuffer&) const;
    // Around the dispatch of volume.comp that fills them.
    void beginMarch(const vk::raii::CommandBuffer&) const;
    void endMarch(const vk::raii::CommandBuffer&) const;

  private:
    const Gpu* gpu_;
    GpuImage colour_, depth_;
};

}  // namespace stylet::render
