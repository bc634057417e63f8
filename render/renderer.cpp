#include "render/renderer.h"

#include <cstring>
#include <map>
#include <optional>
#include <tuple>

#include "render/memory.h"
#include "render/patient_volume.h"
#include "render/pipelines.h"
#include "render/scene_meshes.h"
#include "render/shaders.h"
#include "render/uniforms.h"

namespace stylet::render {
namespace {

constexpr vk::Format kDepthFormat = vk::Format::eD32Sfloat;
constexpr vk::Format kImageFormat = vk::Format::eR8G8B8A8Srgb;
constexpr std::uint32_t kBindings = 8;

const ImageState kFresh{vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eAllCommands, {}};
const ImageState kColourDrawn{
    vk::ImageLayout::eColorAttachmentOptimal, vk::PipelineStageFlagBits2::eColorAttachmentOutput,
    vk::AccessFlagBits2::eColorAttachmentWrite | vk::AccessFlagBits2::eColorAttachmentRead};
const ImageState kDepthDrawn{
    vk::ImageLayout::eDepthAttachmentOptimal,
    vk::PipelineStageFlagBits2::eEarlyFragmentTests | vk::PipelineStageFlagBits2::eLateFragmentTests,
    vk::AccessFlagBits2::eDepthStencilAttachmentWrite | vk::AccessFlagBits2::eDepthStencilAttachmentRead};
const ImageState kDepthRead{vk::ImageLayout::eShaderReadOnlyOptimal,
                            vk::PipelineStageFlagBits2::eFragmentShader,
                            vk::AccessFlagBits2::eShaderSampledRead};

// Calls f and turns Vulkan's exceptions into the module's own.
template <typename F>
auto guarded(F&& f) {
    try {
        return f();
    } catch (const vk::Error& e) {
        throw GpuError(e.what());
    }
}

vk::raii::DescriptorSetLayout makeSetLayout(const Gpu& gpu) {
    using Type = vk::DescriptorType;
    constexpr std::array types{Type::eUniformBuffer,        Type::eUniformBuffer,
                               Type::eCombinedImageSampler, Type::eCombinedImageSampler,
                               Type::eStorageBuffer,        Type::eCombinedImageSampler,
                               Type::eStorageBuffer,        Type::eCombinedImageSampler};
    static_assert(types.size() == kBindings);
    std::array<vk::DescriptorSetLayoutBinding, kBindings> bindings;
    for (std::uint32_t i = 0; i < kBindings; ++i)
        bindings[i] = {.binding = i,
                       .descriptorType = types[i],
                       .descriptorCount = 1,
                       .stageFlags = vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment};
    return gpu.device().createDescriptorSetLayout({.bindingCount = kBindings, .pBindings = bindings.data()});
}

vk::raii::DescriptorPool makePool(const Gpu& gpu) {
    const std::array sizes{vk::DescriptorPoolSize{vk::DescriptorType::eUniformBuffer, 2},
                           vk::DescriptorPoolSize{vk::DescriptorType::eCombinedImageSampler, 4},
                           vk::DescriptorPoolSize{vk::DescriptorType::eStorageBuffer, 2}};
    return gpu.device().createDescriptorPool({.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                              .maxSets = 1,
                                              .poolSizeCount = std::uint32_t(sizes.size()),
                                              .pPoolSizes = sizes.data()});
}

vk::raii::PipelineLayout makeLayout(const Gpu& gpu, vk::DescriptorSetLayout set) {
    const vk::PushConstantRange push{vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0,
                                     sizeof(gpu::MeshPush)};
    return gpu.device().createPipelineLayout({.setLayoutCount = 1,
                                              .pSetLayouts = &set,
                                              .pushConstantRangeCount = 1,
                                              .pPushConstantRanges = &push});
}

// Outside the volume lies clear air.
constexpr auto kClearAir = vk::SamplerAddressMode::eClampToBorder;

vk::raii::Sampler makeSampler(const Gpu& gpu, vk::Filter filter, vk::SamplerAddressMode beyond) {
    return gpu.device().createSampler({.magFilter = filter,
                                       .minFilter = filter,
                                       .addressModeU = beyond,
                                       .addressModeV = beyond,
                                       .addressModeW = beyond,
                                       .borderColor = vk::BorderColor::eFloatTransparentBlack});
}

vk::raii::ImageView layerView(const Gpu& gpu, vk::Image image, vk::Format format, vk::ImageAspectFlags aspect,
                              std::uint32_t first, std::uint32_t count) {
    return gpu.device().createImageView({.image = image,
                                         .viewType = vk::ImageViewType::e2DArray,
                                         .format = format,
                                         .subresourceRange = {aspect, 0, 1, first, count}});
}

// How the eyes are reached: one pass over both layers, or one over each.
struct EyePass {
    std::uint32_t first_eye = 0, view_mask = 0, layers = 1, instances = 1;
    vk::raii::ImageView colour = nullptr, depth = nullptr;
};

enum class Kind : std::uint8_t { mesh, backdrop, volume };
using PipelineKey = std::tuple<Kind, VkFormat, std::array<std::uint32_t, 5>>;

}  // namespace

struct Renderer::Impl {
    Gpu& gpu;
    RenderSettings settings;
    std::array<LookStyle, 2> looks;
    SceneMeshes meshes;
    vk::raii::DescriptorSetLayout set_layout;
    vk::raii::DescriptorPool pool;
    vk::raii::DescriptorSet set = nullptr;
    vk::raii::PipelineLayout layout;
    vk::raii::Sampler linear, steady, nearest;
    vk::raii::QueryPool times;
    Buffer frame_buffer, look_buffer, counter_buffer;
    std::map<PipelineKey, vk::raii::Pipeline> pipelines;
    std::optional<PatientVolume> volume;
    GpuImage depth, colour;  // colour: drawToImages' own

    Impl(Gpu&, const RenderSettings&, const std::filesystem::path& assets);
    void sizeDepth(std::uint32_t width, std::uint32_t height);
    void bindResources();
    std::vector<EyePass> passesFor(const StereoTarget&) const;
    vk::Pipeline pipeline(Kind, vk::Format, std::array<std::uint32_t, 5> constants = {});
    void prepare(const RenderScene&, const std::array<View, 2>&, const StereoTarget&, bool still);
    void record(const vk::raii::CommandBuffer&, const RenderScene&, const StereoTarget&,
                const std::vector<EyePass>&, bool still);
    void beginPass(const vk::raii::CommandBuffer&, const EyePass&, const StereoTarget&, bool opaque) const;
    void drawOpaque(const vk::raii::CommandBuffer&, const EyePass&, const std::vector<MeshDraw>&, vk::Format);
    RenderStats draw(const RenderScene&, const std::array<View, 2>&, const StereoTarget&);
    RenderStats readStats(bool still) const;
};

Renderer::Impl::Impl(Gpu& g, const RenderSettings& s, const std::filesystem::path& assets)
    : gpu(g),
      settings(s),
      looks{loadLook(assets / "looks" / "closed.toml"), loadLook(assets / "looks" / "reveal.toml")},
      meshes(g, assets),
      set_layout(makeSetLayout(g)),
      pool(makePool(g)),
      layout(makeLayout(g, *set_layout)),
      linear(makeSampler(g, vk::Filter::eLinear, kClearAir)),
      steady(makeSampler(g, vk::Filter::eLinear, vk::SamplerAddressMode::eClampToEdge)),
      nearest(makeSampler(g, vk::Filter::eNearest, kClearAir)),
      times(g.device(), vk::QueryPoolCreateInfo{.queryType = vk::QueryType::eTimestamp, .queryCount = 2}),
      frame_buffer(g, sizeof(gpu::FrameUniforms), vk::BufferUsageFlagBits::eUniformBuffer),
      look_buffer(g, sizeof(gpu::LookUniforms), vk::BufferUsageFlagBits::eUniformBuffer),
      counter_buffer(g, sizeof(gpu::Counters), vk::BufferUsageFlagBits::eStorageBuffer) {
    set = std::move(g.device()
                        .allocateDescriptorSets(
                            {.descriptorPool = *pool, .descriptorSetCount = 1, .pSetLayouts = &*set_layout})
                        .front());
}

void Renderer::Impl::sizeDepth(std::uint32_t width, std::uint32_t height) {
    if (depth.extent.width == width && depth.extent.height == height) return;
    depth = GpuImage(gpu, kDepthFormat, {width, height, 1}, 2,
                     vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eSampled);
}

void Renderer::Impl::bindResources() {
    using Type = vk::DescriptorType;
    std::vector<vk::WriteDescriptorSet> writes;
    std::array<vk::DescriptorBufferInfo, kBindings> buffers;
    std::array<vk::DescriptorImageInfo, kBindings> images;
    const auto bindBuffer = [&](std::uint32_t binding, const Buffer& buffer, Type type) {
        buffers[binding] = vk::DescriptorBufferInfo{*buffer.handle, 0, VK_WHOLE_SIZE};
        writes.push_back({.dstSet = *set,
                          .dstBinding = binding,
                          .descriptorCount = 1,
                          .descriptorType = type,
                          .pBufferInfo = &buffers[binding]});
    };
    const auto bindImage = [&](std::uint32_t binding, const GpuImage& image,
                               const vk::raii::Sampler& sampler) {
        images[binding] =
            vk::DescriptorImageInfo{*sampler, *image.view, vk::ImageLayout::eShaderReadOnlyOptimal};
        writes.push_back({.dstSet = *set,
                          .dstBinding = binding,
                          .descriptorCount = 1,
                          .descriptorType = Type::eCombinedImageSampler,
                          .pImageInfo = &images[binding]});
    };
    bindBuffer(0, frame_buffer, Type::eUniformBuffer);
    bindBuffer(1, look_buffer, Type::eUniformBuffer);
    bindImage(3, depth, nearest);
    bindBuffer(6, counter_buffer, Type::eStorageBuffer);
    // Without a patient nothing reads these, but lavapipe of Mesa 22.3 walks every binding and none may be
    // empty.
    bindImage(2, volume ? volume->classified() : depth, linear);
    bindBuffer(4, volume ? volume->bricks() : counter_buffer, Type::eStorageBuffer);
    bindImage(5, volume ? volume->inside() : depth, steady);
    bindImage(7, volume ? volume->outside() : depth, steady);
    gpu.device().updateDescriptorSets(writes, {});
}

std::vector<EyePass> Renderer::Impl::passesFor(const StereoTarget& target) const {
    std::vector<EyePass> passes;
    const bool single = gpu.stereoPath() == StereoPath::single;
    const bool multiview = gpu.stereoPath() == StereoPath::multiview;
    const std::uint32_t layers = single ? 1 : 2;
    for (std::uint32_t eye = 0; eye < 2; eye += layers)
        passes.push_back({.first_eye = eye,
                          .view_mask = multiview ? 0b11u : 0u,
                          .layers = multiview ? 1 : layers,
                          .instances = multiview ? 1 : layers,
                          .colour = layerView(gpu, target.image, vk::Format(target.format),
                                              vk::ImageAspectFlagBits::eColor, eye, layers),
                          .depth = layerView(gpu, *depth.handle, kDepthFormat,
                                             vk::ImageAspectFlagBits::eDepth, eye, layers)});
    return passes;
}

// Made on first need.
vk::Pipeline Renderer::Impl::pipeline(Kind kind, vk::Format format, std::array<std::uint32_t, 5> constants) {
    const PipelineKey key{kind, VkFormat(format), constants};
    const auto known = pipelines.find(key);
    if (known != pipelines.end()) return *known->second;
    const StereoPath path = gpu.stereoPath();
    const auto pick = [&](std::span<const std::uint32_t> multiview, std::span<const std::uint32_t> layered,
                          std::span<const std::uint32_t> single) {
        return path == StereoPath::multiview ? multiview : path == StereoPath::layered ? layered : single;
    };
    using namespace shaders;
    PipelineShape shape{.vertex = pick(kScreenVertMultiview, kScreenVertLayered, kScreenVertSingle),
                        .fragment = kVolumeFrag,
                        .colour = format,
                        .view_mask = path == StereoPath::multiview ? 0b11u : 0u};
    constexpr std::array attributes{
        vk::VertexInputAttributeDescription{0, 0, vk::Format::eR32G32B32Sfloat, offsetof(Vertex, position_m)},
        vk::VertexInputAttributeDescription{1, 0, vk::Format::eR32G32B32Sfloat, offsetof(Vertex, normal)}};
    switch (kind) {
        case Kind::mesh:
            shape.vertex = pick(kMeshVertMultiview, kMeshVertLayered, kMeshVertSingle);
            shape.fragment = kMeshFrag;
            shape.attributes = attributes;
            shape.vertex_stride = sizeof(Vertex);
            shape.depth = kDepthFormat;
            shape.depth_use = DepthUse::test_and_write;
            break;
        case Kind::backdrop:
            shape.fragment = kBackdropFrag;
            shape.depth = kDepthFormat;
            shape.depth_use = DepthUse::test;
            break;
        case Kind::volume:
            shape.constants = constants;
            shape.blend = Blend::over;
            break;
    }
    return *pipelines.emplace(key, makePipeline(gpu, *layout, shape)).first->second;
}

void Renderer::Impl::prepare(const RenderScene& scene, const std::array<View, 2>& views,
                             const StereoTarget& target, bool still) {
    const LookStyle& look = looks[std::size_t(scene.look)];
    sizeDepth(target.width, target.height);
    if (volume) {
        volume->show(look);
        volume->breathe(scene.breath, still);
    }
    const gpu::FrameUniforms frame =
        frameUniforms(scene, views, settings, target.width, target.height, volume ? &*volume : nullptr, look);
    frame_buffer.write(&frame, sizeof frame);
    const gpu::LookUniforms surface = lookUniforms(look);
    look_buffer.write(&surface, sizeof surface);
    const gpu::Counters zero{};
    counter_buffer.write(&zero, sizeof zero);
    bindResources();
}

void Renderer::Impl::beginPass(const vk::raii::CommandBuffer& commands, const EyePass& pass,
                               const StereoTarget& target, bool opaque) const {
    const vk::RenderingAttachmentInfo colour_info{
        .imageView = *pass.colour,
        .imageLayout = vk::ImageLayout::eColorAttachmentOptimal,
        .loadOp = opaque ? vk::AttachmentLoadOp::eDontCare : vk::AttachmentLoadOp::eLoad,
        .storeOp = vk::AttachmentStoreOp::eStore};
    const vk::RenderingAttachmentInfo depth_info{.imageView = *pass.depth,
                                                 .imageLayout = vk::ImageLayout::eDepthAttachmentOptimal,
                                                 .loadOp = vk::AttachmentLoadOp::eClear,
                                                 .storeOp = vk::AttachmentStoreOp::eStore,
                                                 .clearValue = vk::ClearDepthStencilValue{0.0f, 0}};
    commands.beginRendering({.renderArea = {{0, 0}, {target.width, target.height}},
                             .layerCount = pass.layers,
                             .viewMask = pass.view_mask,
                             .colorAttachmentCount = 1,
                             .pColorAttachments = &colour_info,
                             .pDepthAttachment = opaque ? &depth_info : nullptr});
    commands.setViewport(0, vk::Viewport{0, 0, float(target.width), float(target.height), 0, 1});
    commands.setScissor(0, vk::Rect2D{{0, 0}, {target.width, target.height}});
    commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout, 0, *set, {});
}

void Renderer::Impl::drawOpaque(const vk::raii::CommandBuffer& commands, const EyePass& pass,
                                const std::vector<MeshDraw>& draws, vk::Format format) {
    constexpr auto stages = vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment;
    commands.bindVertexBuffers(0, *meshes.vertices().handle, vk::DeviceSize{0});
    commands.bindIndexBuffer(*meshes.indices().handle, 0, vk::IndexType::eUint32);
    if (!draws.empty()) commands.bindPipeline(vk::PipelineBindPoint::eGraphics, pipeline(Kind::mesh, format));
    for (const MeshDraw& draw : draws) {
        gpu::MeshPush push = draw.push;
        push.material.z = float(pass.first_eye);
        commands.pushConstants<gpu::MeshPush>(*layout, stages, 0, push);
        commands.drawIndexed(draw.index_count, pass.instances, draw.first_index, 0, 0);
    }
    commands.bindPipeline(vk::PipelineBindPoint::eGraphics, pipeline(Kind::backdrop, format));
    gpu::MeshPush push{};
    push.material.z = float(pass.first_eye);
    commands.pushConstants<gpu::MeshPush>(*layout, stages, 0, push);
    commands.draw(3, pass.instances, 0, 0);
}

void Renderer::Impl::record(const vk::raii::CommandBuffer& commands, const RenderScene& scene,
                            const StereoTarget& target, const std::vector<EyePass>& passes, bool still) {
    const auto format = vk::Format(target.format);
    const Skips& skips = settings.skips;
    const std::vector<MeshDraw> draws = meshes.drawsOf(scene, volume ? &*volume : nullptr);
    commands.resetQueryPool(*times, 0, 2);
    commands.writeTimestamp2(vk::PipelineStageFlagBits2::eTopOfPipe, *times, 0);
    transition(commands, target.image, vk::ImageAspectFlagBits::eColor, kColourDrawn, kColourDrawn);
    transition(commands, *depth.handle, vk::ImageAspectFlagBits::eDepth, kFresh, kDepthDrawn);
    for (const EyePass& pass : passes) {
        beginPass(commands, pass, target, true);
        drawOpaque(commands, pass, draws, format);
        commands.endRendering();
    }
    transition(commands, *depth.handle, vk::ImageAspectFlagBits::eDepth, kDepthDrawn, kDepthRead);
    transition(commands, target.image, vk::ImageAspectFlagBits::eColor, kColourDrawn, kColourDrawn);
    if (volume) {
        const vk::Pipeline march = pipeline(
            Kind::volume, format,
            {skips.empty_space, skips.early_termination, skips.depth_bounds, !still, settings.count});
        for (const EyePass& pass : passes) {
            beginPass(commands, pass, target, false);
            commands.bindPipeline(vk::PipelineBindPoint::eGraphics, march);
            gpu::MeshPush push{};
            push.material.z = float(pass.first_eye);
            commands.pushConstants<gpu::MeshPush>(
                *layout, vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0, push);
            commands.draw(3, pass.instances, 0, 0);
            commands.endRendering();
        }
    }
    commands.writeTimestamp2(vk::PipelineStageFlagBits2::eBottomOfPipe, *times, 1);
}

RenderStats Renderer::Impl::readStats(bool still) const {
    RenderStats stats;
    const auto [result, stamps] =
        times.getResults<std::uint64_t>(0, 2, 2 * sizeof(std::uint64_t), sizeof(std::uint64_t),
                                        vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
    if (result == vk::Result::eSuccess)
        stats.gpu_ms = double(stamps[1] - stamps[0]) * 1e-6 *
                       double(gpu.physicalDevice().getProperties().limits.timestampPeriod);
    gpu::Counters counted{};
    std::memcpy(&counted, counter_buffer.mapped, sizeof counted);
    stats.samples = (std::uint64_t(counted.samples_high) << 32) + counted.samples;
    stats.rays = counted.rays;
    stats.skipped_bricks = counted.skipped_bricks;
    stats.terminated_rays = counted.terminated_rays;
    stats.depth_bounded_rays = counted.depth_bounded_rays;
    stats.still_frames = volume && still ? 1 : 0;
    return stats;
}

RenderStats Renderer::Impl::draw(const RenderScene& scene, const std::array<View, 2>& views,
                                 const StereoTarget& target) {
    const bool still =
        settings.skips.still_breath && volume && scene.breath == volume->patient().package().motion.reference;
    prepare(scene, views, target, still);
    const std::vector<EyePass> passes = passesFor(target);
    submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
        record(commands, scene, target, passes, still);
    });
    return readStats(still);
}

Renderer::Renderer(Gpu& gpu, const RenderSettings& settings, const std::filesystem::path& assets)
    : impl_(guarded([&] { return std::make_unique<Impl>(gpu, settings, assets); })) {}

Renderer::~Renderer() = default;

void Renderer::setSettings(const RenderSettings& settings) {
    impl_->settings = settings;
}

void Renderer::setPatient(const patient::Patient& patient) {
    guarded([&] { impl_->volume.emplace(impl_->gpu, patient); });
}

RenderStats Renderer::draw(const RenderScene& scene, const std::array<View, 2>& views,
                           const StereoTarget& target) {
    return guarded([&] { return impl_->draw(scene, views, target); });
}

std::array<Image, 2> Renderer::drawToImages(const RenderScene& scene, const std::array<View, 2>& views,
                                            std::uint32_t width, std::uint32_t height, RenderStats* stats) {
    return guarded([&] {
        GpuImage& image = impl_->colour;
        if (image.extent.width != width || image.extent.height != height) {
            image = GpuImage(impl_->gpu, kImageFormat, {width, height, 1}, 2,
                             vk::ImageUsageFlagBits::eColorAttachment | vk::ImageUsageFlagBits::eTransferSrc);
            submitAndWait(impl_->gpu, [&](const vk::raii::CommandBuffer& commands) {
                transition(commands, *image.handle, vk::ImageAspectFlagBits::eColor, kFresh, kColourDrawn);
            });
        }
        const RenderStats counted =
            impl_->draw(scene, views, {VkImage(*image.handle), VkFormat(kImageFormat), width, height});
        if (stats) *stats = counted;
        std::array<Image, 2> eyes;
        for (std::uint32_t eye = 0; eye < 2; ++eye)
            eyes[eye] = {width, height,
                         readLayer(impl_->gpu, *image.handle, {width, height}, eye, kColourDrawn)};
        return eyes;
    });
}

}  // namespace stylet::render
