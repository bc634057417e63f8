// The volume layer: the picture of the patient before it is laid over the opaque meshes. One image of
// linear premultiplied colour and one of the depth of the first surface, each with a layer per eye.
#pragma once

#include "render/gpu/memory.h"

namespace stylet::render {

class VolumeLayer {
  public:
    explicit VolumeLayer(const Gpu& gpu) : gpu_(&gpu) {}

    // Reserves images for layers of up to this size. Returns true if the images are new.
    bool reserve(vk::Extent2D);

    const GpuImage& colour() const { return colour_; }  // RGBA16F
    const GpuImage& depth() const { return depth_; }    // R32F, m along the eye's -z; 0: no opaque surface

    // Fills the images from tightly packed texels, eye after eye.
    void upload(const vk::raii::CommandBuffer&, const Buffer& colour, const Buffer& depth,
                vk::Extent2D) const;
    // Clears the layer to transparent.
    void clear(const vk::raii::CommandBuffer&) const;
    // Call these around the dispatch of volume.comp that fills the images.
    void beginMarch(const vk::raii::CommandBuffer&) const;
    void endMarch(const vk::raii::CommandBuffer&) const;

  private:
    const Gpu* gpu_;
    GpuImage colour_, depth_;
};

}  // namespace stylet::render
