// The lamp's shadow map: depth of the shadow casters as seen from the lamp. Redrawn only if the lamp or a
// caster has moved.
#pragma once

#include <span>

#include "render/gpu/descriptors.h"
#include "render/room/scene_meshes.h"

namespace stylet::render {

class LampShadow {
  public:
    LampShadow(const Gpu&, std::uint32_t size_px);

    // Returns true if the map must be redrawn (always unless `may_reuse`). Allocates nothing after the
    // first scenes.
    bool aim(const Lamp&, std::span<const MeshDraw>, bool may_reuse);
    void record(const vk::raii::CommandBuffer&, vk::Pipeline, const Descriptors&, const SceneMeshes&) const;

    const glm::mat4& shadowFromStage() const { return shadow_from_stage_; }
    float texel() const { return 1.0f / float(image_.extent.width); }
    const GpuImage& image() const { return image_; }
    const vk::raii::Sampler& sampler() const { return sampler_; }

  private:
    struct Caster {
        std::uint32_t first_index = 0;
        glm::mat4 stage_from_model{1.0f};
        friend bool operator==(const Caster&, const Caster&) = default;
    };
    GpuImage image_;
    vk::raii::Sampler sampler_;
    glm::mat4 shadow_from_stage_{1.0f};
    std::vector<Caster> drawn_, now_;
    bool stale_ = true;
};

}  // namespace stylet::render
