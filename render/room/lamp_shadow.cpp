#include "render/room/lamp_shadow.h"

#include <algorithm>
#include <cstring>

#include "render/gpu/image_states.h"
#include "render/scene/projection.h"

namespace stylet::render {
namespace {

constexpr float kHalfAngle_rad = 0.52f;  // half of the angle that the map covers: 0.6 m around the field
constexpr double kLampNear_m = 0.25, kLampFar_m = 2.6;

const ImageState kShadowDrawn{
    vk::ImageLayout::eDepthAttachmentOptimal,
    vk::PipelineStageFlagBits2::eEarlyFragmentTests | vk::PipelineStageFlagBits2::eLateFragmentTests,
    vk::AccessFlagBits2::eDepthStencilAttachmentWrite | vk::AccessFlagBits2::eDepthStencilAttachmentRead};

}  // namespace

LampShadow::LampShadow(const Gpu& gpu, std::uint32_t size_px)
    : image_(gpu, vk::Format::eD32Sfloat, {size_px, size_px, 1}, 1,
             vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eSampled),
      sampler_(gpu.device(), vk::SamplerCreateInfo{.magFilter = vk::Filter::eLinear,
                                                   .minFilter = vk::Filter::eLinear,
                                                   .addressModeU = vk::SamplerAddressMode::eClampToEdge,
                                                   .addressModeV = vk::SamplerAddressMode::eClampToEdge,
                                                   .addressModeW = vk::SamplerAddressMode::eClampToEdge,
                                                   .compareEnable = true,
                                                   .compareOp = vk::CompareOp::eGreaterOrEqual}) {
    submitAndWait(gpu, [&](const vk::raii::CommandBuffer& buffer) {
        transition(buffer, *image_.handle, vk::ImageAspectFlagBits::eDepth, kFreshImage, kShaderRead);
    });
}

bool LampShadow::aim(const Lamp& lamp, std::span<const MeshDraw> draws, bool may_reuse) {
    const View view{lamp.stage_from_head, -kHalfAngle_rad, kHalfAngle_rad, kHalfAngle_rad, -kHalfAngle_rad};
    const glm::mat4 aimed(clipFromEye(view, kLampNear_m, kLampFar_m) *
                          toMatrix(lamp.stage_from_head.inverse()));
    now_.clear();
    for (const MeshDraw& draw : draws)
        if (draw.casts) now_.push_back({draw.first_index, draw.push.stage_from_model});
    // Draws are ordered by distance from the eye. Sort the casters in a fixed order, to compare them between
    // frames. The parts of a tube share one model, so their places must decide.
    std::sort(now_.begin(), now_.end(), [](const Caster& a, const Caster& b) {
        if (a.first_index != b.first_index) return a.first_index < b.first_index;
        return std::memcmp(&a.stage_from_model, &b.stage_from_model, sizeof a.stage_from_model) < 0;
    });
    if (may_reuse && !stale_ && aimed == shadow_from_stage_ && now_ == drawn_) return false;
    shadow_from_stage_ = aimed;
    std::swap(now_, drawn_);
    stale_ = false;
    return true;
}

void LampShadow::record(const vk::raii::CommandBuffer& buffer, vk::Pipeline pipeline,
                        const Descriptors& descriptors, const SceneMeshes& meshes) const {
    const vk::Extent2D size{image_.extent.width, image_.extent.height};
    transition(buffer, *image_.handle, vk::ImageAspectFlagBits::eDepth, kFreshImage, kShadowDrawn);
    const vk::RenderingAttachmentInfo depth{.imageView = *image_.view,
                                            .imageLayout = vk::ImageLayout::eDepthAttachmentOptimal,
                                            .loadOp = vk::AttachmentLoadOp::eClear,
                                            .storeOp = vk::AttachmentStoreOp::eStore,
                                            .clearValue = vk::ClearDepthStencilValue{0.0f, 0}};
    buffer.beginRendering({.renderArea = {{0, 0}, size}, .layerCount = 1, .pDepthAttachment = &depth});
    buffer.setViewport(0, vk::Viewport{0, 0, float(size.width), float(size.height), 0, 1});
    buffer.setScissor(0, vk::Rect2D{{0, 0}, size});
    descriptors.use(buffer, vk::PipelineBindPoint::eGraphics);
    buffer.bindVertexBuffers(0, *meshes.vertices().handle, vk::DeviceSize{0});
    buffer.bindIndexBuffer(*meshes.indices().handle, 0, vk::IndexType::eUint32);
    buffer.bindPipeline(vk::PipelineBindPoint::eGraphics, pipeline);
    for (const MeshDraw& draw : meshes.all()) {
        if (!draw.casts) continue;
        buffer.pushConstants<gpu::MeshPush>(
            descriptors.layout(), vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0,
            draw.push);
        buffer.drawIndexed(draw.index_count, 1, draw.first_index, 0, 0);
    }
    buffer.endRendering();
    transition(buffer, *image_.handle, vk::ImageAspectFlagBits::eDepth, kShadowDrawn, kShaderRead);
}

}  // namespace stylet::render
