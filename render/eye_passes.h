// How both eyes of a target are reached: one pass over both layers, or one over each.
#pragma once

#include <vector>

#include "render/memory.h"
#include "render/renderer.h"

namespace stylet::render {

inline constexpr vk::Format kDepthFormat = vk::Format::eD32Sfloat;

struct EyePass {
    std::uint32_t first_eye = 0, view_mask = 0, layers = 1, instances = 1;
    vk::raii::ImageView colour = nullptr, depth = nullptr, submitted_depth = nullptr;
};

// What is drawn into one target: made once for each image of a swapchain, then found again.
class EyePasses {
  public:
    explicit EyePasses(const Gpu& gpu) : gpu_(&gpu) {}

    // `depth`: the renderer's own, as large as the target.
    const std::vector<EyePass>& of(const StereoTarget&, const GpuImage& depth);
    // To be called before an image that was drawn to is destroyed.
    void forget() { known_.clear(); }

  private:
    struct Known {
        VkImage image = VK_NULL_HANDLE, depth_image = VK_NULL_HANDLE;
        VkFormat format = VK_FORMAT_UNDEFINED;
        std::vector<EyePass> passes;
    };
    const Gpu* gpu_;
    std::vector<Known> known_;
};

}  // namespace stylet::render
