// Marches the volume layer on the processor, between two submissions of a frame. The mesh depth is read
// back from the GPU, and the layer is uploaded.
#pragma once

#include <algorithm>

#include "base/parallel.h"
#include "render/gpu/memory.h"
#include "render/volume/layer.h"
#include "render/volume/march.h"
#include "render/volume/patient_volume.h"

namespace stylet::render {

class MarchLayer {
  public:
    explicit MarchLayer(const Gpu& gpu) : gpu_(&gpu), workers_(std::max(2, processorCount() - 1)) {}

    void reserve(vk::Extent2D target);
    // Records the read-back of `depth` at the end of the opaque pass. `depth` has the target's size and is
    // in `state` before and after.
    void readDepth(const vk::raii::CommandBuffer&, const GpuImage& depth, const ImageState& state) const;
    // Call after the read-back has finished.
    gpu::Counters march(const gpu::FrameUniforms&, const gpu::LookUniforms&, const PatientVolume&,
                        const DeformedPatient&, const RenderSettings&);
    void upload(const vk::raii::CommandBuffer&, const VolumeLayer&, vk::Extent2D layer) const;

  private:
    const Gpu* gpu_;
    Workers workers_;  // all but one core (at least two threads), to leave one for the other loops
    vk::Extent2D target_{};
    Buffer mesh_depth_, colour_, depth_;
};

}  // namespace stylet::render
