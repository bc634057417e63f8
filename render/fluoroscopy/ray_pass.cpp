#include "render/fluoroscopy/ray_pass.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/gpu/image_states.h"
#include "render/gpu/pipelines.h"
#include "render/scene/projection.h"
#include "render/shaders.h"

namespace stylet::render {
namespace {

constexpr auto kRayStorage = vk::DescriptorType::eStorageBuffer,
               kRayImage = vk::DescriptorType::eCombinedImageSampler;
// Bindings of rays.comp: types, and their numbers.
constexpr std::array kRayBindings{kRayStorage, kRayImage,   kRayImage,   kRayImage,  kRayImage,
                                  kRayImage,   kRayStorage, kRayStorage, kRayStorage};
enum class At { uniforms, tissue, cells, inside, outside, toolMoved, paths, meter, counters };

// Margin around a cell [m]. First term: half a segment, times 1.33 because the motion may stretch tissue.
// Second term: the distance from a ray to its block's middle, where the motion is looked up.
double marginFor(const FluoroscopySettings& settings) {
    const double pixel_m = settings.detector_m / settings.pixels;
    return 0.5 * 1.33 * settings.segment_m + 0.5 * std::sqrt(2.0) * (settings.block - 1) * pixel_m;
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

RayPass::Features RayPass::requiredFeatures(const FluoroscopySettings& settings) const {
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
    image_revision_ = patient_->imageRevision();
}

bool RayPass::prepare(const FluoroscopyInput& input, const FluoroscopySettings& settings) {
    bool other = image_revision_ != patient_->imageRevision();
    other |= tissue_.prepare(patient_->patient().package().ct, settings.voxel_m, marginFor(settings));
    const std::size_t side = std::size_t(settings.pixels);
    if (paths_.size != sizeof(float) * side * side) {
        paths_ = Buffer(*gpu_, sizeof(float) * side * side, vk::BufferUsageFlagBits::eStorageBuffer);
        other = true;
    }
    if (other) bind();
    return tissue_.show(input.contrast, !settings.skips.unchanged_contrast);
}

gpu::XrayUniforms RayPass::makeUniforms(const Beam& beam, const FluoroscopyInput& input,
                                        const FluoroscopySettings& settings) const {
    const Collimation& c = input.collimation;
    const Grid& ct = patient_->patient().grid();
    const double pixel_m = settings.detector_m / settings.pixels;
    const Vec3 beyond(0.5 * ct.spacing_m.x, 0.5 * ct.spacing_m.y,
                      0.5 * ct.spacing_m.z + settings.beyond_ends_m);
    const double samples =
        gpu::kToolParts *
        std::max(1.0, std::ceil(settings.segment_m / (gpu::kToolParts * settings.step_m) - 1e-6));
    const Grid& cells = tissue_.cellGrid();
    const ToImage tissue = toImage(tissue_.grid());
    gpu::XrayUniforms u{};
    u.source = toVec4(beam.source_m, settings.pixels);
    u.first = toVec4(pixelAt(beam, 0, 0, settings.pixels, settings.detector_m), kWaterPerM);
    u.right = toVec4(pixel_m * beam.right, pixel_m);
    u.down = toVec4(pixel_m * beam.down);
    u.blades = glm::vec4(c.left_m, c.right_m, c.up_m, c.down_m);
    const std::size_t count = std::min(input.shapes.size(), std::size_t(kMaxXrayShapes));
    u.iris = glm::vec4(c.iris_m.value_or(0.0), double(count), gpu::meterStride(settings.pixels), 0.0);
    u.box_low = toVec4(ct.origin_m - beyond, settings.segment_m);
    u.box_high = toVec4(ct.centre(ct.dims - 1) + beyond, samples);
    u.tissue_scale = tissue.scale, u.tissue_offset = tissue.offset;
    u.cell_scale = toVec4(1.0 / cells.spacing_m);
    u.cell_offset = toVec4(0.5 - cells.origin_m / cells.spacing_m);
    setMotion(u, *patient_);
    for (std::size_t i = 0; i < count; ++i) {
        const XrayShape& s = input.shapes[i];
        u.shapes[i] = {toVec4(s.begin_m, s.radius_m), toVec4(s.end_m, s.bore_m),
                       glm::vec4(s.per_m, s.round ? 1.0 : 0.0, s.chained ? 1.0 : 0.0, 0.0)};
    }
    return u;
}

void RayPass::record(const vk::raii::CommandBuffer& commands, const Beam& beam, const FluoroscopyInput& input,
                     const FluoroscopySettings& settings) {
    const gpu::XrayUniforms u = makeUniforms(beam, input, settings);
    uniforms_.write(&u, sizeof u);
    std::memset(counters_.mapped, 0, std::size_t(counters_.size));
    std::fill_n(static_cast<float*>(meter_.mapped), gpu::kMeter * gpu::kMeter, -1.0f);
    patient_->recordUploads(commands);
    tissue_.recordUpload(commands);
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelineFor(requiredFeatures(settings)));
    descriptors_.use(commands, vk::PipelineBindPoint::eCompute);
    const std::uint32_t groups = groupCount(settings.pixels, settings.block * gpu::kXrayGroup);
    commands.dispatch(groups, groups, 1);
    memoryBarrier(commands, kComputeWrites,
                  {vk::PipelineStageFlagBits2::eComputeShader | vk::PipelineStageFlagBits2::eHost,
                   vk::AccessFlagBits2::eShaderStorageRead | vk::AccessFlagBits2::eHostRead});
}

}  // namespace stylet::render
