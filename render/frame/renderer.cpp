#include "render/frame/renderer.h"

#include <cassert>
#include <cstring>
#include <map>
#include <optional>
#include <tuple>

#include <fmt/core.h>

#include "render/frame/eye_passes.h"
#include "render/frame/uniforms.h"
#include "render/gpu/descriptors.h"
#include "render/gpu/guarded.h"
#include "render/gpu/image_states.h"
#include "render/gpu/pipelines.h"
#include "render/room/room.h"
#include "render/scene/frame_bindings.h"
#include "render/shaders.h"
#include "render/volume/downsample.h"
#include "render/volume/layer.h"
#include "render/volume/march_layer.h"
#include "render/volume/march_shared.h"
#include "render/volume/patient_volume.h"

namespace stylet::render {
namespace {

constexpr vk::Format kImageFormat = vk::Format::eR8G8B8A8Srgb;
constexpr auto kVertexAndFragment = vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment;

const ImageState kDepthDrawn{
    vk::ImageLayout::eDepthStencilAttachmentOptimal,
    vk::PipelineStageFlagBits2::eEarlyFragmentTests | vk::PipelineStageFlagBits2::eLateFragmentTests,
    vk::AccessFlagBits2::eDepthStencilAttachmentWrite | vk::AccessFlagBits2::eDepthStencilAttachmentRead};

// Samples outside the volume read clear air.
constexpr auto kClearAir = vk::SamplerAddressMode::eClampToBorder;

enum class Kind : std::uint8_t { hidden, caster, mesh, backdrop, march, composite, depth };
using Constants = std::array<std::uint32_t, 9>;
using PipelineKey = std::tuple<Kind, VkFormat, Constants>;

// Time stamps that the GPU writes during a frame.
enum Stamp : std::uint32_t { kBegin, kOpaqueDone, kMarchDone, kEnd, kStamps };

// Triangles that the lenses hide, for both eyes. x, y: tangents; z: eye index.
struct HiddenArea {
    Buffer vertices;
    std::uint32_t count = 0;
};

struct DownsampledPatient {
    DownsampledPatient(const patient::Patient& fine, int factor)
        : package(downsample(fine.package(), factor)) {}
    const patient::Package package;
    const patient::Patient patient{package};
};
constexpr int kCoarsest = 8;

}  // namespace

struct Renderer::Impl {
    Gpu& gpu;
    RenderSettings settings;
    std::array<LookStyle, 2> looks;
    Room room;
    Commands commands;
    Descriptors descriptors;
    vk::raii::Sampler linear, linear_clamped, nearest;
    vk::raii::QueryPool times;
    Buffer frame_buffer, look_buffer, counter_buffer;
    std::map<PipelineKey, vk::raii::Pipeline> pipelines;
    std::optional<DeformedPatient> deformed;
    std::optional<PatientVolume> volume;
    GpuImage depth;  // of the opaque meshes
    VolumeLayer layer;
    std::optional<MarchLayer> march_layer;  // created on the first march on the processor
    gpu::FrameUniforms frame{};
    gpu::LookUniforms surface{};
    EyePasses eye_passes;
    std::array<std::vector<glm::vec3>, 2> hidden_triangles;
    HiddenArea hidden;
    GpuImage own_colour, own_depth;  // used by drawToImages()
    bool stale_bindings = true;
    int bound_images = 0;                        // deformed->imageRevision() at the last update
    std::unique_ptr<DownsampledPatient> coarse;  // shown instead of a patient that does not fit
    std::vector<std::string> notes;

    Impl(Gpu&, const RenderSettings&, const std::filesystem::path& assets);
    void size(vk::Extent2D);
    void bindResources();
    void loadPatient(const patient::Patient&);
    bool marchesOnProcessor() const;
    PatientVolume::Reader reader() const;
    const PatientVolume* shownVolume() const { return volume ? &*volume : nullptr; }
    vk::Pipeline pipeline(Kind, vk::Format = vk::Format::eUndefined, const Constants& = {});
    bool usesTool(const RenderScene& scene) const { return scene.tool || !settings.skips.idle_tool; }
    Constants marchConstants(const RenderScene&, bool still) const;
    vk::Extent2D prepare(const RenderScene&, const std::array<View, 2>&, const StereoTarget&, bool still);
    void record(const vk::raii::CommandBuffer&, const RenderScene&, const StereoTarget&,
                vk::Extent2D layer_size, bool still);
    void drawWithProcessor(const RenderScene&, const StereoTarget&, vk::Extent2D layer_size);
    void recordOpaque(const vk::raii::CommandBuffer&, const RenderScene&, const StereoTarget&);
    void recordMarch(const vk::raii::CommandBuffer&, const RenderScene&, vk::Extent2D layer_size, bool still);
    void recordComposite(const vk::raii::CommandBuffer&, const StereoTarget&, vk::Extent2D layer_size);
    void recordDepth(const vk::raii::CommandBuffer&, const StereoTarget&);
    void beginPass(const vk::raii::CommandBuffer&, const EyePass&, const StereoTarget&, vk::ImageView colour,
                   vk::ImageView depth, vk::AttachmentLoadOp load) const;
    void drawTriangles(const vk::raii::CommandBuffer&, const EyePass&, vk::Pipeline,
                       std::uint32_t vertices = 3) const;
    void drawOpaque(const vk::raii::CommandBuffer&, const EyePass&, bool backdrop, vk::Format);
    void stamp(const vk::raii::CommandBuffer&, Stamp) const;
    RenderStats draw(const RenderScene&, const std::array<View, 2>&, const StereoTarget&);
    RenderStats readStats(const StereoTarget&, vk::Extent2D layer_size, bool still) const;
    void ownTarget(vk::Extent2D, bool with_depth);
};

Renderer::Impl::Impl(Gpu& g, const RenderSettings& s, const std::filesystem::path& assets)
    : gpu(g),
      settings(s),
      looks{loadLook(assets / "looks" / "closed.toml"), loadLook(assets / "looks" / "reveal.toml")},
      room(g, assets),
      commands(g),
      descriptors(g, kFrameBindings, {kVertexAndFragment, 0, sizeof(gpu::MeshPush)}),
      linear(makeSampler(g, vk::Filter::eLinear, kClearAir)),
      linear_clamped(makeSampler(g, vk::Filter::eLinear, vk::SamplerAddressMode::eClampToEdge)),
      nearest(makeSampler(g, vk::Filter::eNearest, kClearAir)),
      times(g.device(),
            vk::QueryPoolCreateInfo{.queryType = vk::QueryType::eTimestamp, .queryCount = kStamps}),
      frame_buffer(g, sizeof(gpu::FrameUniforms), vk::BufferUsageFlagBits::eUniformBuffer),
      look_buffer(g, sizeof(gpu::LookUniforms), vk::BufferUsageFlagBits::eUniformBuffer),
      counter_buffer(g, sizeof(gpu::Counters), vk::BufferUsageFlagBits::eStorageBuffer),
      layer(g),
      eye_passes(g) {}

void Renderer::Impl::size(vk::Extent2D target) {
    if (!depth.hasSize(target)) {
        eye_passes.clear();
        depth = GpuImage(gpu, kDepthFormat, {target.width, target.height, 1}, 2,
                         vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eSampled |
                             vk::ImageUsageFlagBits::eTransferSrc);
        stale_bindings = true;
    }
    if (layer.reserve(target)) stale_bindings = true;
}

void Renderer::Impl::bindResources() {
    const int images = deformed ? deformed->imageRevision() : 0;
    if (!stale_bindings && images == bound_images) return;
    bound_images = images;
    descriptors.bind(Binding::frame, frame_buffer);
    descriptors.bind(Binding::look, look_buffer);
    descriptors.bind(Binding::mesh_depth, depth, nearest);
    descriptors.bind(Binding::counters, counter_buffer);
    descriptors.bindStorage(Binding::layer_colour, layer.colour());
    descriptors.bindStorage(Binding::layer_depth, layer.depth());
    // Without a patient nothing reads these bindings, but each must name a resource.
    descriptors.bind(Binding::classified, volume ? volume->classified() : depth, linear);
    descriptors.bind(Binding::bricks, volume ? volume->bricks() : counter_buffer);
    descriptors.bind(Binding::deform_inside, deformed ? deformed->inside() : depth, linear_clamped);
    descriptors.bind(Binding::deform_outside, deformed ? deformed->outside() : depth, linear_clamped);
    descriptors.bind(Binding::tool_moved, deformed ? deformed->toolMoved() : depth, linear_clamped);
    room.bind(descriptors);
    descriptors.update();
    stale_bindings = false;
}

// Creates the pipeline on first use.
vk::Pipeline Renderer::Impl::pipeline(Kind kind, vk::Format format, const Constants& constants) {
    const PipelineKey key{kind, VkFormat(format), constants};
    const auto known = pipelines.find(key);
    if (known != pipelines.end()) return *known->second;
    const StereoPath path = gpu.stereoPath();
    const auto pick = [&](std::span<const std::uint32_t> multiview, std::span<const std::uint32_t> layered,
                          std::span<const std::uint32_t> single) {
        return path == StereoPath::multiview ? multiview : path == StereoPath::layered ? layered : single;
    };
    using namespace shaders;
    const auto made = [&](vk::raii::Pipeline&& one) {
        return *pipelines.emplace(key, std::move(one)).first->second;
    };
    PipelineShape shape{.vertex = pick(kScreenVertMultiview, kScreenVertLayered, kScreenVertSingle),
                        .colour = format,
                        .view_mask = path == StereoPath::multiview ? 0b11u : 0u};
    const auto setMesh = [&](std::span<const std::uint32_t> vertex, std::span<const std::uint32_t> fragment,
                             std::span<const vk::VertexInputAttributeDescription> attributes,
                             std::size_t stride) {
        shape.vertex = vertex, shape.fragment = fragment;
        shape.attributes = attributes, shape.vertex_stride = std::uint32_t(stride);
        shape.depth = kDepthFormat, shape.depth_use = DepthUse::test_and_write;
    };
    const auto setScreen = [&](std::span<const std::uint32_t> fragment, DepthUse depth_use) {
        shape.fragment = fragment;
        shape.depth_use = depth_use;
        if (depth_use != DepthUse::none) shape.depth = kDepthFormat;
    };
    switch (kind) {
        case Kind::hidden:
            setMesh(pick(kHiddenVertMultiview, kHiddenVertLayered, kHiddenVertSingle), kHiddenFrag,
                    roomAttributes().first(1), sizeof(glm::vec3));
            break;
        case Kind::caster:
            setMesh(kShadowVert, kShadowFrag, roomAttributes().first(1), sizeof(RoomVertex));
            shape.view_mask = 0;
            break;
        case Kind::mesh:
            setMesh(pick(kMeshVertMultiview, kMeshVertLayered, kMeshVertSingle), kMeshFrag, roomAttributes(),
                    sizeof(RoomVertex));
            shape.constants = constants;
            shape.cull_back = int(constants[0]) != gpu::kCloth;
            break;
        case Kind::backdrop:
            setScreen(kBackdropFrag, DepthUse::test);
            break;
        case Kind::march:
            return made(makeComputePipeline(gpu, descriptors.layout(), kVolumeComp, constants));
        case Kind::composite:
            setScreen(kCompositeFrag, DepthUse::none);
            shape.constants = constants;
            shape.blend = Blend::over;
            break;
        case Kind::depth:
            setScreen(kDepthFrag, DepthUse::write);
            break;
    }
    return made(makePipeline(gpu, descriptors.layout(), shape));
}

Constants Renderer::Impl::marchConstants(const RenderScene& scene, bool still) const {
    const Skips& skips = settings.skips;
    return {skips.empty_space, skips.early_termination, skips.depth_bounds,   !still,
            settings.count,    !scene.cuts.empty(),     !scene.marks.empty(), settings.foveation.has_value(),
            usesTool(scene)};
}

PatientVolume::Reader Renderer::Impl::reader() const {
    return marchesOnProcessor() ? PatientVolume::Reader::host : PatientVolume::Reader::gpu;
}

// Loads the patient at full resolution, or in the finest voxels that the device can hold.
void Renderer::Impl::loadPatient(const patient::Patient& patient) {
    volume.reset();
    deformed.emplace(gpu, patient);
    room.releasePatient();
    coarse.reset();
    notes.clear();
    stale_bindings = true;
    const int longest = std::max({patient.grid().dims.x, patient.grid().dims.y, patient.grid().dims.z});
    const int limit =
        int(std::min(gpu.physicalDevice().getProperties().limits.maxImageDimension3D, 1u << 20));
    int factor = marchesOnProcessor() ? 1 : (longest + limit - 1) / limit;
    std::string why = fmt::format("its images have at most {} voxels along an edge", limit);
    for (;; ++factor) {
        try {
            if (factor > 1) coarse = std::make_unique<DownsampledPatient>(patient, factor);
            volume.emplace(gpu, coarse ? coarse->patient : patient, *deformed, reader());
            break;
        } catch (const vk::OutOfDeviceMemoryError&) {
            if (factor >= kCoarsest) throw;
            why = "its memory holds no more";
        }
    }
    if (factor > 1)
        notes.push_back(fmt::format(
            "this graphics device shows the patient in voxels of {} times the size: {}", factor, why));
}

bool Renderer::Impl::marchesOnProcessor() const {
    if (settings.volume_path != VolumePath::automatic) return settings.volume_path == VolumePath::processor;
    return gpu.isSoftware();
}

vk::Extent2D Renderer::Impl::prepare(const RenderScene& scene, const std::array<View, 2>& views,
                                     const StereoTarget& target, bool still) {
    const LookStyle& look = looks[std::size_t(scene.look)];
    const vk::Extent2D extent{target.width, target.height};
    size(extent);
    if (volume) {
        if (volume->show(look, reader())) stale_bindings = true;
        deformed->breathe(scene.breath, still);
        deformed->press(scene.tool);
        volume->updateBricks();
    }
    const vk::Extent2D layer_size =
        volume ? layerExtent(scene, views, settings, extent, volume->patient().grid()) : extent;
    frame = frameUniforms(scene, views, settings, {extent, layer_size}, shownVolume(), look);
    frame_buffer.write(&frame, sizeof frame);
    room.prepare(scene, views, settings.skips, shownVolume());
    surface = lookUniforms(look);
    look_buffer.write(&surface, sizeof surface);
    const gpu::Counters zero{};
    counter_buffer.write(&zero, sizeof zero);
    bindResources();
    return layer_size;
}

void Renderer::Impl::beginPass(const vk::raii::CommandBuffer& buffer, const EyePass& pass,
                               const StereoTarget& target, vk::ImageView colour_view,
                               vk::ImageView depth_view, vk::AttachmentLoadOp load) const {
    const vk::RenderingAttachmentInfo colour_info{.imageView = colour_view,
                                                  .imageLayout = vk::ImageLayout::eColorAttachmentOptimal,
                                                  .loadOp = load,
                                                  .storeOp = vk::AttachmentStoreOp::eStore};
    const vk::RenderingAttachmentInfo depth_info{
        .imageView = depth_view,
        .imageLayout = vk::ImageLayout::eDepthStencilAttachmentOptimal,
        .loadOp = vk::AttachmentLoadOp::eClear,
        .storeOp = vk::AttachmentStoreOp::eStore,
        .clearValue = vk::ClearDepthStencilValue{0.0f, 0}};
    buffer.beginRendering({.renderArea = {{0, 0}, {target.width, target.height}},
                           .layerCount = pass.layers,
                           .viewMask = pass.view_mask,
                           .colorAttachmentCount = colour_view ? 1u : 0u,
                           .pColorAttachments = &colour_info,
                           .pDepthAttachment = depth_view ? &depth_info : nullptr});
    buffer.setViewport(0, vk::Viewport{0, 0, float(target.width), float(target.height), 0, 1});
    buffer.setScissor(0, vk::Rect2D{{0, 0}, {target.width, target.height}});
    descriptors.use(buffer, vk::PipelineBindPoint::eGraphics);
}

// Draws without a vertex buffer; with three vertices, a triangle over the whole target.
void Renderer::Impl::drawTriangles(const vk::raii::CommandBuffer& buffer, const EyePass& pass,
                                   vk::Pipeline shown, std::uint32_t vertices) const {
    buffer.bindPipeline(vk::PipelineBindPoint::eGraphics, shown);
    gpu::MeshPush push{};
    push.material.z = float(pass.first_eye);
    buffer.pushConstants<gpu::MeshPush>(descriptors.layout(), kVertexAndFragment, 0, push);
    buffer.draw(vertices, pass.instances, 0, 0);
}

void Renderer::Impl::drawOpaque(const vk::raii::CommandBuffer& buffer, const EyePass& pass, bool backdrop,
                                vk::Format format) {
    if (hidden.count > 0) {
        buffer.bindVertexBuffers(0, *hidden.vertices.handle, vk::DeviceSize{0});
        drawTriangles(buffer, pass, pipeline(Kind::hidden, format), hidden.count);
    }
    const SceneMeshes& meshes = room.meshes();
    const auto useBuffers = [&](const Buffer& vertices, const Buffer& indices) {
        buffer.bindVertexBuffers(0, *vertices.handle, vk::DeviceSize{0});
        buffer.bindIndexBuffer(*indices.handle, 0, vk::IndexType::eUint32);
    };
    useBuffers(meshes.vertices(), meshes.indices());
    int kind = -1, lamp = -1;
    for (const MeshDraw& draw : meshes.visible()) {
        if (draw.kind != kind || draw.lamp != lamp)
            buffer.bindPipeline(
                vk::PipelineBindPoint::eGraphics,
                pipeline(Kind::mesh, format, {std::uint32_t(draw.kind), std::uint32_t(draw.lamp)}));
        kind = draw.kind, lamp = draw.lamp;
        gpu::MeshPush push = draw.push;
        push.material.z = float(pass.first_eye);
        buffer.pushConstants<gpu::MeshPush>(descriptors.layout(), kVertexAndFragment, 0, push);
        const bool cloth = draw.kind == gpu::kCloth;
        if (cloth) useBuffers(room.drape()->vertices(), room.drape()->indices());
        buffer.drawIndexed(draw.index_count, pass.instances, draw.first_index, 0, 0);
        if (cloth) useBuffers(meshes.vertices(), meshes.indices());
    }
    if (backdrop) drawTriangles(buffer, pass, pipeline(Kind::backdrop, format));
}

void Renderer::Impl::stamp(const vk::raii::CommandBuffer& buffer, Stamp at) const {
    buffer.writeTimestamp2(vk::PipelineStageFlagBits2::eAllCommands, *times, at);
}

void Renderer::Impl::recordOpaque(const vk::raii::CommandBuffer& buffer, const RenderScene& scene,
                                  const StereoTarget& target) {
    room.recordBefore(buffer, pipeline(Kind::caster), descriptors);
    transition(buffer, target.image, kColour, kColourDrawn, kColourDrawn);
    transition(buffer, *depth.handle, vk::ImageAspectFlagBits::eDepth, kFreshImage, kDepthDrawn);
    for (const EyePass& pass : eye_passes.passesFor(target, depth)) {
        const RoomContents& shown = scene.room;
        beginPass(buffer, pass, target, *pass.colour, *pass.depth,
                  shown.real ? vk::AttachmentLoadOp::eClear : vk::AttachmentLoadOp::eDontCare);
        drawOpaque(buffer, pass, !shown.shell && !shown.real, vk::Format(target.format));
        buffer.endRendering();
    }
    transition(buffer, *depth.handle, vk::ImageAspectFlagBits::eDepth, kDepthDrawn, kShaderRead);
    transition(buffer, target.image, kColour, kColourDrawn, kColourDrawn);
}

void Renderer::Impl::recordMarch(const vk::raii::CommandBuffer& buffer, const RenderScene& scene,
                                 vk::Extent2D layer_size, bool still) {
    layer.beginMarch(buffer);
    buffer.bindPipeline(vk::PipelineBindPoint::eCompute,
                        pipeline(Kind::march, vk::Format::eUndefined, marchConstants(scene, still)));
    descriptors.use(buffer, vk::PipelineBindPoint::eCompute);
    buffer.dispatch(groupCount(int(layer_size.width), gpu::kTile),
                    groupCount(int(layer_size.height), gpu::kTile), 2);
    if (settings.count) memoryBarrier(buffer, kComputeWrites, kHostReads);
    layer.endMarch(buffer);
}

void Renderer::Impl::recordComposite(const vk::raii::CommandBuffer& buffer, const StereoTarget& target,
                                     vk::Extent2D layer_size) {
    const bool upsample = layer_size != vk::Extent2D{target.width, target.height};
    const vk::Pipeline over =
        pipeline(Kind::composite, vk::Format(target.format), {upsample, room.castsShadows()});
    for (const EyePass& pass : eye_passes.passesFor(target, depth)) {
        beginPass(buffer, pass, target, *pass.colour, nullptr, vk::AttachmentLoadOp::eLoad);
        drawTriangles(buffer, pass, over);
        buffer.endRendering();
    }
}

void Renderer::Impl::recordDepth(const vk::raii::CommandBuffer& buffer, const StereoTarget& target) {
    const vk::Image submitted = target.depth_image;
    transition(buffer, submitted, vk::ImageAspectFlagBits::eDepth, kDepthDrawn, kDepthDrawn);
    for (const EyePass& pass : eye_passes.passesFor(target, depth)) {
        beginPass(buffer, pass, target, nullptr, *pass.submitted_depth, vk::AttachmentLoadOp::eDontCare);
        drawTriangles(buffer, pass, pipeline(Kind::depth));
        buffer.endRendering();
    }
    transition(buffer, submitted, vk::ImageAspectFlagBits::eDepth, kDepthDrawn, kDepthDrawn);
}

void Renderer::Impl::record(const vk::raii::CommandBuffer& buffer, const RenderScene& scene,
                            const StereoTarget& target, vk::Extent2D layer_size, bool still) {
    buffer.resetQueryPool(*times, 0, kStamps);
    stamp(buffer, kBegin);
    if (volume) deformed->recordUploads(buffer);
    recordOpaque(buffer, scene, target);
    stamp(buffer, kOpaqueDone);
    if (volume)
        recordMarch(buffer, scene, layer_size, still);
    else if (target.depth_image)
        layer.clear(buffer);
    stamp(buffer, kMarchDone);
    if (volume) recordComposite(buffer, target, layer_size);
    if (target.depth_image) recordDepth(buffer, target);
    if (!gpu.isSoftware()) stamp(buffer, kEnd);
}

// Marches on the processor, between two submissions.
void Renderer::Impl::drawWithProcessor(const RenderScene& scene, const StereoTarget& target,
                                       vk::Extent2D layer_size) {
    if (!march_layer) march_layer.emplace(gpu);
    march_layer->reserve({target.width, target.height});
    commands.submitAndWait([&](const vk::raii::CommandBuffer& buffer) {
        buffer.resetQueryPool(*times, 0, kStamps);
        stamp(buffer, kBegin);
        recordOpaque(buffer, scene, target);
        march_layer->readDepth(buffer, depth, kShaderRead);
        stamp(buffer, kOpaqueDone);
    });
    const gpu::Counters counters = march_layer->march(frame, surface, *volume, *deformed, settings);
    counter_buffer.write(&counters, sizeof counters);
    commands.submitAndWait([&](const vk::raii::CommandBuffer& buffer) {
        march_layer->upload(buffer, layer, layer_size);
        stamp(buffer, kMarchDone);
        recordComposite(buffer, target, layer_size);
        if (target.depth_image) recordDepth(buffer, target);
        if (!gpu.isSoftware()) stamp(buffer, kEnd);
    });
}

RenderStats Renderer::Impl::readStats(const StereoTarget& target, vk::Extent2D layer_size, bool still) const {
    RenderStats stats;
    std::array<std::uint64_t, kStamps> stamps{};
    const vk::Result result =
        (*gpu.device())
            .getQueryPoolResults(*times, 0, kStamps, sizeof stamps, stamps.data(), sizeof stamps[0],
                                 vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait,
                                 *gpu.device().getDispatcher());
    if (result == vk::Result::eSuccess) {
        const double tick_ms = 1e-6 * double(gpu.physicalDevice().getProperties().limits.timestampPeriod);
        const auto between = [&](Stamp a, Stamp b) { return tick_ms * double(stamps[b] - stamps[a]); };
        stats.gpu_ms = between(kBegin, kEnd);
        stats.opaque_ms = between(kBegin, kOpaqueDone);
        stats.volume_ms = between(kOpaqueDone, kMarchDone);
    }
    stats.layer_scale = double(layer_size.width) / target.width;
    gpu::Counters counted{};
    std::memcpy(&counted, counter_buffer.mapped, sizeof counted);
    stats.samples = (std::uint64_t(counted.samples_high) << 32) + counted.samples;
    stats.rays = counted.rays;
    stats.skipped_bricks = counted.skipped_bricks;
    stats.terminated_rays = counted.terminated_rays;
    stats.depth_bounded_rays = counted.depth_bounded_rays;
    stats.still_frames = volume && still ? 1 : 0;
    stats.culled_parts = room.meshes().culled();
    stats.reused_shadows = room.reusedShadow() ? 1 : 0;
    return stats;
}

RenderStats Renderer::Impl::draw(const RenderScene& scene, const std::array<View, 2>& views,
                                 const StereoTarget& target) {
    const bool still = settings.skips.still_breath && deformed && deformed->atRest(scene.breath);
    const vk::Extent2D layer_size = prepare(scene, views, target, still);
    if (volume && marchesOnProcessor())
        drawWithProcessor(scene, target, layer_size);
    else
        commands.submitAndWait(
            [&](const vk::raii::CommandBuffer& buffer) { record(buffer, scene, target, layer_size, still); });
    // Lavapipe of Mesa 25 crashes on a time stamp after the composite, so a software device submits it
    // separately.
    if (gpu.isSoftware())
        commands.submitAndWait([&](const vk::raii::CommandBuffer& buffer) { stamp(buffer, kEnd); });
    RenderStats stats = readStats(target, layer_size, still);
    stats.idle_tool_frames = volume && !usesTool(scene) ? 1 : 0;
    return stats;
}

// Creates the images that drawToImages() draws to and reads back.
void Renderer::Impl::ownTarget(vk::Extent2D extent, bool with_depth) {
    const auto make = [&](GpuImage& image, vk::Format format, vk::ImageUsageFlags usage,
                          vk::ImageAspectFlags aspect, const ImageState& state) {
        eye_passes.clear();
        image = GpuImage(gpu, format, {extent.width, extent.height, 1}, 2,
                         usage | vk::ImageUsageFlagBits::eTransferSrc);
        commands.submitAndWait([&](const vk::raii::CommandBuffer& buffer) {
            transition(buffer, *image.handle, aspect, kFreshImage, state);
        });
    };
    if (!own_colour.hasSize(extent))
        make(own_colour, kImageFormat, vk::ImageUsageFlagBits::eColorAttachment, kColour, kColourDrawn);
    if (with_depth && !own_depth.hasSize(extent))
        make(own_depth, kDepthFormat, vk::ImageUsageFlagBits::eDepthStencilAttachment,
             vk::ImageAspectFlagBits::eDepth, kDepthDrawn);
}

Renderer::Renderer(Gpu& gpu, const RenderSettings& settings, const std::filesystem::path& assets)
    : impl_(guarded([&] { return std::make_unique<Impl>(gpu, settings, assets); })) {}

Renderer::~Renderer() = default;

void Renderer::setSettings(const RenderSettings& settings) {
    impl_->settings = settings;
}

void Renderer::setLook(Look look, const LookStyle& style) {
    impl_->looks[std::size_t(look)] = style;
    if (impl_->volume) impl_->volume->invalidateLook();
}

void Renderer::setHiddenArea(int eye, std::span<const glm::vec2> tangents,
                             std::span<const std::uint32_t> indices) {
    Impl& me = *impl_;
    auto& corners = me.hidden_triangles[std::size_t(eye)];
    corners.clear();
    for (const std::uint32_t i : indices) {
        assert(i < tangents.size());
        corners.emplace_back(tangents[i], float(eye));
    }
    std::vector<glm::vec3> both = me.hidden_triangles[0];
    both.insert(both.end(), me.hidden_triangles[1].begin(), me.hidden_triangles[1].end());
    me.hidden = {};
    if (both.empty()) return;
    guarded(
        [&] { me.hidden.vertices = makeFilledBuffer(me.gpu, both, vk::BufferUsageFlagBits::eVertexBuffer); });
    me.hidden.count = std::uint32_t(both.size());
}

void Renderer::setPatient(const patient::Patient& patient) {
    guarded([&] { impl_->loadPatient(patient); });
}

RenderStats Renderer::draw(const RenderScene& scene, const std::array<View, 2>& views,
                           const StereoTarget& target) {
    return guarded([&] { return impl_->draw(scene, views, target); });
}

DeformedPatient& Renderer::deformedPatient() {
    assert(impl_->deformed);
    return *impl_->deformed;
}

Pose Renderer::patientFromIsocentre(const RenderScene& scene) const {
    assert(scene.room.c_arm);
    const Placement placed = computePlacement(scene, impl_->shownVolume());
    return scene.stage_from_patient.inverse() * stageFromIsocentre(scene, *scene.room.c_arm, placed);
}

VisibleScreens Renderer::visibleScreens(const RenderScene& scene, const std::array<View, 2>& views) const {
    return impl_->room.visibleScreens(scene, views, impl_->shownVolume());
}

ScreenPlaces Renderer::screenPlaces(const RenderScene& scene) const {
    return impl_->room.screenPlaces(scene, impl_->shownVolume());
}

const std::vector<std::string>& Renderer::notes() const {
    return impl_->notes;
}

std::array<Image, 2> Renderer::drawToImages(const RenderScene& scene, const std::array<View, 2>& views,
                                            std::uint32_t width, std::uint32_t height, RenderStats* stats,
                                            std::array<DepthImage, 2>* depths) {
    return guarded([&] {
        Impl& me = *impl_;
        me.ownTarget({width, height}, depths != nullptr);
        const RenderStats counted = me.draw(scene, views,
                                            {*me.own_colour.handle, VkFormat(kImageFormat), width, height,
                                             depths ? VkImage(*me.own_depth.handle) : VK_NULL_HANDLE});
        if (stats) *stats = counted;
        std::array<Image, 2> eyes;
        for (std::uint32_t eye = 0; eye < 2; ++eye) {
            eyes[eye] = {
                width, height,
                readLayer(me.gpu, *me.own_colour.handle, kColour, {width, height}, eye, kColourDrawn)};
            if (!depths) continue;
            const std::vector<std::uint8_t> bytes =
                readLayer(me.gpu, *me.own_depth.handle, vk::ImageAspectFlagBits::eDepth, {width, height}, eye,
                          kDepthDrawn);
            DepthImage& read = (*depths)[eye];
            read = {width, height, std::vector<float>(std::size_t(width) * height)};
            std::memcpy(read.reversed.data(), bytes.data(), bytes.size());
        }
        return eyes;
    });
}

}  // namespace stylet::render
