#include "render/frame/eye_passes.h"

#include <algorithm>

namespace stylet::render {
namespace {

vk::raii::ImageView layerView(const Gpu& gpu, vk::Image image, vk::Format format, std::uint32_t first,
                              std::uint32_t count) {
    const auto aspect =
        format == kDepthFormat ? vk::ImageAspectFlagBits::eDepth : vk::ImageAspectFlagBits::eColor;
    return gpu.device().createImageView({.image = image,
                                         .viewType = vk::ImageViewType::e2DArray,
                                         .format = format,
                                         .subresourceRange = {aspect, 0, 1, first, count}});
}

}  // namespace

const std::vector<EyePass>& EyePasses::passesFor(const StereoTarget& target, const GpuImage& depth) {
    const auto found = std::find_if(cache_.begin(), cache_.end(), [&](const CachedPasses& k) {
        return k.image == target.image && k.depth_image == target.depth_image && k.format == target.format;
    });
    if (found != cache_.end()) return found->passes;
    const bool single = gpu_->stereoPath() == StereoPath::single;
    const bool multiview = gpu_->stereoPath() == StereoPath::multiview;
    const std::uint32_t layers = single ? 1 : 2;
    CachedPasses made{target.image, target.depth_image, target.format, {}};
    for (std::uint32_t eye = 0; eye < 2; eye += layers) {
        EyePass pass{.first_eye = eye,
                     .view_mask = multiview ? 0b11u : 0u,
                     .layers = multiview ? 1 : layers,
                     .instances = multiview ? 1 : layers,
                     .colour = layerView(*gpu_, target.image, vk::Format(target.format), eye, layers),
                     .depth = layerView(*gpu_, *depth.handle, kDepthFormat, eye, layers)};
        if (target.depth_image)
            pass.submitted_depth = layerView(*gpu_, target.depth_image, kDepthFormat, eye, layers);
        made.passes.push_back(std::move(pass));
    }
    cache_.push_back(std::move(made));
    return cache_.back().passes;
}

}  // namespace stylet::render
