// The layer marched on the processor, between two submissions of a frame: depth comes down, colour goes up.
#pragma once

#include <algorithm>
#include <thread>

#include "render/memory.h"
#include "render/volume/layer.h"
#include "render/volume/march.h"
#include "render/volume/patient_volume.h"

namespace stylet::render {

class MarchLayer {
  public:
    explicit MarchLayer(const Gpu& gpu)
        : gpu_(&gpu), workers_(std::max(2, int(std::thread::hardware_concurrency()) - 1)) {}

    void reserve(vk::Extent2D target);
    // At the end of the opaque pass: `depth` of the target's size, in `state` before and after.
    void readDepth(const vk::raii::CommandBuffer&, const GpuImage& depth, const ImageState& state) const;
    // When that is done.
    gpu::Counters march(const gpu::FrameUniforms&, const gpu::LookUniforms&, const PatientVolume&,
                        const DeformedPatient&, const RenderSettings&);
    void upload(const vk::raii::CommandBuffer&, const VolumeLayer&, vk::Extent2D layer) const;

  private:
    const Gpu* gpu_;
    Workers workers_;  // all but one core, where there are more than two: the other loops go on
    vk::Extent2D target_{};
    Buffer mesh_depth_, colour_, depth_;
};

}  // namespace stylet::render
