// Passes that cover both eyes of a target: one pass over both layers, or one pass per layer.
#pragma once

#include <vector>

#include "render/frame/renderer.h"
#include "render/gpu/memory.h"

namespace stylet::render {

inline constexpr vk::Format kDepthFormat = vk::Format::eD32Sfloat;

struct EyePass {
    std::uint32_t first_eye = 0, view_mask = 0, layers = 1, instances = 1;
    vk::raii::ImageView colour = nullptr, depth = nullptr, submitted_depth = nullptr;
};

// Caches the passes of each target. They are created once per swapchain image.
class EyePasses {
  public:
    explicit EyePasses(const Gpu& gpu) : gpu_(&gpu) {}

    // `depth`: the renderer's own depth image, of the target's size.
    const std::vector<EyePass>& passesFor(const StereoTarget&, const GpuImage& depth);
    // Call before destroying an image that was drawn to.
    void clear() { cache_.clear(); }

  private:
    struct CachedPasses {
        VkImage image = VK_NULL_HANDLE, depth_image = VK_NULL_HANDLE;
        VkFormat format = VK_FORMAT_UNDEFINED;
        std::vector<EyePass> passes;
    };
    const Gpu* gpu_;
    std::vector<CachedPasses> cache_;
};

}  // namespace stylet::render
