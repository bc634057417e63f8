#include "render/fluoroscopy/ray_pass.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <thread>

#include "render/gpu/pipelines.h"
#include "render/shaders.h"

namespace stylet::render {
namespace {

constexpr auto kRayStorage = vk::DescriptorType::eStorageBuffer,
               kRayImage = vk::DescriptorType::eCombinedImageSampler;
// Binding numbers of rays.comp.
constexpr std::array kRayBindings{kRayStorage, kRayImage,   kRayImage,   kRayImage,  kRayImage,
                                  kRayImage,   kRayStorage, kRayStorage, kRayStorage};
enum class At { uniforms, tissue, cells, inside, outside, toolMoved, paths, meter, counters };

// Margin around a cell [m]: half a stretch, a third more where the motion stretches tissue, plus the
// distance between the rays of a block and the point where it looks up the motion.
double marginFor(const FluoroscopySettings& settings) {
    const double pixel_m = settings.detector_m / settings.pixels;
    return 0.5 * 1.33 * settings.stretch_m + 0.5 * std::sqrt(2.0) * (settings.block - 1) * pixel_m;
}
glm::vec4 vec4Of(const Vec3& v, double w = 0.0) {
    return glm::vec4(glm::vec3(v), float(w));
}
Vec3 toTextureScale(const Grid& grid) {
    return 1.0 / (grid.spacing_m * Vec3(grid.dims));
}
Vec3 toTextureOffset(const Grid& grid) {
    return 0.5 / Vec3(grid.dims) - grid.origin_m * toTextureScale(grid);
}
Vec3 toCellOffset(const Grid& grid) {
    return 0.5 - grid.origin_m / grid.spacing_m;
}

}  // namespace

RayPass::RayPass(const Gpu& gpu, DeformedPatient& patient)
    : gpu_(&gpu),
      patient_(&patient),
      edge_(makeSampler(gpu, vk::Filter::eLinear, vk::SamplerAddressMode::eClampToEdge)),
      nearest_(makeSampler(gpu, vk::Filter::eNearest, vk::SamplerAddressMode::eClampToEdge)),
      descriptors_(gpu, kRayBindings, {}),
      tissue_(gpu),
      uniforms_(gpu, sizeof(gpu::XrayUniforms), vk::BufferUsageFlagBits::eStorageBuffer),
      meter_(gpu, sizeof(float) * gpu::kMeter * gpu::kMeter, vk::BufferUsageFlagBits::eStorageBuffer),
      counters_(gpu, sizeof(gpu::XrayCounters), vk::BufferUsageFlagBits::eStorageBuffer) {}

RayPass::Features RayPass::featuresOf(const FluoroscopySettings& settings) const {
    const FluoroscopySkips& skips = settings.skips;
    return {.deform = !patient_->still(),
            .tool = patient_->tool() || !skips.idle_tool,
            .empty_cells = skips.empty_cells,
            .collimate = skips.collimated_rays,
            .count = settings.count,
            .block = std::uint32_t(settings.block)};
}

const vk::raii::Pipeline& RayPass::pipelineFor(const Features& f) {
    const auto known = pipelines_.find(f);
    if (known != pipelines_.end()) return known->second;
    const std::array constants{f.deform, f.tool, f.empty_cells, f.collimate, f.count, f.block};
    return pipelines_
        .emplace(f, makeComputePipeline(*gpu_, descriptors_.layout(), shaders::kFluoroscopyRays, constants))
        .first->second;
}

void RayPass::bind() {
    descriptors_.bind(At::uniforms, uniforms_);
    descriptors_.bind(At::tissue, tissue_.tissue(), edge_);
    descriptors_.bind(At::cells, tissue_.cells(), nearest_);
    descriptors_.bind(At::inside, patient_->inside(), edge_);
    descriptors_.bind(At::outside, patient_->outside(), edge_);
    descriptors_.bind(At::toolMoved, patient_->toolMoved(), edge_);
    descriptors_.bind(At::paths, paths_);
    descriptors_.bind(At::meter, meter_);
    descriptors_.bind(At::counters, counters_);
    descriptors_.update();
    images_made_ = patient_->imagesMade();
}

bool RayPass::prepare(const FluoroscopyInput& input, const FluoroscopySettings& settings) {
    bool other = images_made_ != patient_->imagesMade();
    other |= tissue_.prepare(patient_->patient().package().ct, settings.voxel_m, marginFor(settings));
    const std::size_t side = std::size_t(settings.pixels);
    if (paths_.size != sizeof(float) * side * side) {
        paths_ = Buffer(*gpu_, sizeof(float) * side * side, vk::BufferUsageFlagBits::eStorageBuffer);
        other = true;
    }
    if (other) bind();
    return tissue_.show(input.contrast, !settings.skips.kept_contrast);
}

gpu::XrayUniforms RayPass::uniformsOf(const Beam& beam, const FluoroscopyInput& input,
                                      const FluoroscopySettings& settings) const {
    const Collimation& c = input.collimation;
    const Grid& ct = patient_->patient().grid();
    const double pixel_m = settings.detector_m / settings.pixels;
    const Vec3 beyond(0.5 * ct.spacing_m.x, 0.5 * ct.spacing_m.y,
                      0.5 * ct.spacing_m.z + settings.beyond_ends_m);
    const double samples =
        gpu::kToolParts *
        std::max(1.0, std::ceil(settings.stretch_m / (gpu::kToolParts * settings.step_m) - 1e-6));
    const DeformedPatient::ToImage deformation = patient_->toDeformation(), tool = patient_->toTool();
    gpu::XrayUniforms u{};
    u.source = vec4Of(beam.source_m, settings.pixels);
    u.first = vec4Of(pixelAt(beam, 0, 0, settings.pixels, settings.detector_m), kWaterPerM);
    u.right = vec4Of(pixel_m * beam.right, pixel_m);
    u.down = vec4Of(pixel_m * beam.down);
    u.blades = glm::vec4(c.left_m, c.right_m, c.up_m, c.down_m);
    const std::size_t count = std::min(input.shapes.size(), std::size_t(kMostXrayShapes));
    u.iris = glm::vec4(c.iris_m.value_or(0.0), double(count), gpu::meterStride(settings.pixels), 0.0);
    u.box_low = vec4Of(ct.origin_m - beyond, settings.stretch_m);
    u.box_high = vec4Of(ct.centre(ct.dims - 1) + beyond, samples);
    u.tissue_scale = vec4Of(toTextureScale(tissue_.grid()));
    u.tissue_offset = vec4Of(toTextureOffset(tissue_.grid()));
    u.cell_scale = vec4Of(1.0 / tissue_.cellGrid().spacing_m);
    u.cell_offset = vec4Of(toCellOffset(tissue_.cellGrid()));
    u.deform_scale = deformation.scale, u.deform_offset = deformation.offset;
    u.tool_scale = tool.scale, u.tool_offset = tool.offset;
    for (std::size_t i = 0; i < count; ++i) {
        const XrayShape& s = input.shapes[i];
        u.shapes[i] = {vec4Of(s.begin_m, s.radius_m), vec4Of(s.end_m, s.bore_m),
                       glm::vec4(s.per_m, s.round ? 1.0 : 0.0, s.chained ? 1.0 : 0.0, 0.0)};
    }
    return u;
}

void RayPass::record(const vk::raii::CommandBuffer& commands, const Beam& beam, const FluoroscopyInput& input,
                     const FluoroscopySettings& settings) {
    const gpu::XrayUniforms u = uniformsOf(beam, input, settings);
    uniforms_.write(&u, sizeof u);
    std::memset(counters_.mapped, 0, std::size_t(counters_.size));
    std::fill_n(static_cast<float*>(meter_.mapped), gpu::kMeter * gpu::kMeter, -1.0f);
    patient_->recordUploads(commands);
    tissue_.recordUpload(commands);
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelineFor(featuresOf(settings)));
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, descriptors_.layout(), 0, descriptors_.set(),
                                {});
    const std::uint32_t groups =
        std::uint32_t((settings.pixels - 1) / (settings.block * gpu::kXrayGroup) + 1);
    commands.dispatch(groups, groups, 1);
    const vk::MemoryBarrier2 done{
        .srcStageMask = vk::PipelineStageFlagBits2::eComputeShader,
        .srcAccessMask = vk::AccessFlagBits2::eShaderStorageWrite,
        .dstStageMask = vk::PipelineStageFlagBits2::eComputeShader | vk::PipelineStageFlagBits2::eHost,
        .dstAccessMask = vk::AccessFlagBits2::eShaderStorageRead | vk::AccessFlagBits2::eHostRead};
    commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &done});
}

}  // namespace stylet::render
