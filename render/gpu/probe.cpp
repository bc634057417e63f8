#include "render/gpu/probe.h"

#include <array>

#include "render/gpu/image_states.h"
#include "render/gpu/pipelines.h"
#include "render/shaders.h"

namespace stylet::render {

bool probeMultiview(const Gpu& gpu) {
    const vk::Format format = vk::Format::eR8G8B8A8Unorm;
    const GpuImage target(gpu, format, {1, 1, 1}, 2,
                          vk::ImageUsageFlagBits::eColorAttachment | vk::ImageUsageFlagBits::eTransferSrc);
    const vk::raii::PipelineLayout layout(gpu.device(), vk::PipelineLayoutCreateInfo{});
    const vk::raii::Pipeline pipeline = makePipeline(gpu, *layout,
                                                     {.vertex = shaders::kProbeVert,
                                                      .fragment = shaders::kProbeFrag,
                                                      .colour = format,
                                                      .view_mask = 0b11});
    const ImageState drawn{vk::ImageLayout::eColorAttachmentOptimal,
                           vk::PipelineStageFlagBits2::eColorAttachmentOutput,
                           vk::AccessFlagBits2::eColorAttachmentWrite};
    submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
        transition(commands, *target.handle, kColour, kUnused, drawn);
        const vk::RenderingAttachmentInfo colour{.imageView = *target.view,
                                                 .imageLayout = vk::ImageLayout::eColorAttachmentOptimal,
                                                 .loadOp = vk::AttachmentLoadOp::eClear,
                                                 .storeOp = vk::AttachmentStoreOp::eStore};
        commands.beginRendering({.renderArea = {{0, 0}, {1, 1}},
                                 .layerCount = 1,
                                 .viewMask = 0b11,
                                 .colorAttachmentCount = 1,
                                 .pColorAttachments = &colour});
        commands.setViewport(0, vk::Viewport{0, 0, 1, 1, 0, 1});
        commands.setScissor(0, vk::Rect2D{{0, 0}, {1, 1}});
        commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipeline);
        commands.draw(3, 1, 0, 0);
        commands.endRendering();
    });
    const int left = readLayer(gpu, *target.handle, kColour, {1, 1}, 0, drawn)[0];
    const int right = readLayer(gpu, *target.handle, kColour, {1, 1}, 1, drawn)[0];
    return left > 100 && left < 150 && right == 255;
}

}  // namespace stylet::render
