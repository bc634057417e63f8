// Line integrals on the GPU: inputs and dispatch of rays.comp.
#pragma once

#include <map>

#include "render/fluoroscopy/fluoroscopy.h"
#include "render/fluoroscopy/fluoroscopy_shared.h"
#include "render/fluoroscopy/tissue_image.h"
#include "render/gpu/descriptors.h"

namespace stylet::render {

class RayPass {
  public:
    RayPass(const Gpu&, DeformedPatient&);

    // Prepares the volume with contrast, and the buffers for the pixels. Returns true if contrast was
    // written.
    bool prepare(const FluoroscopyInput&, const FluoroscopySettings&);
    // Records the upload of changed patient and contrast data and the dispatch. Afterwards the results are
    // visible to compute shaders and the host.
    void record(const vk::raii::CommandBuffer&, const Beam&, const FluoroscopyInput&,
                const FluoroscopySettings&);

    const Buffer& paths() const { return paths_; }  // row after row
    std::span<const float> meter() const {
        return {static_cast<const float*>(meter_.mapped), std::size_t(gpu::kMeter * gpu::kMeter)};
    }
    const gpu::XrayCounters& counters() const {
        return *static_cast<const gpu::XrayCounters*>(counters_.mapped);
    }

  private:
    // Specialisation constants of rays.comp.
    struct Features {
        std::uint32_t deform, tool, empty_cells, collimate, count, block;
        auto operator<=>(const Features&) const = default;
    };
    Features requiredFeatures(const FluoroscopySettings&) const;
    const vk::raii::Pipeline& pipelineFor(const Features&);
    void bind();
    gpu::XrayUniforms makeUniforms(const Beam&, const FluoroscopyInput&, const FluoroscopySettings&) const;

    const Gpu* gpu_;
    DeformedPatient* patient_;
    vk::raii::Sampler edge_, nearest_;
    Descriptors descriptors_;
    TissueImage tissue_;
    Buffer uniforms_, paths_, meter_, counters_;
    std::map<Features, vk::raii::Pipeline> pipelines_;
    int image_revision_ = -1;
};

}  // namespace stylet::render
