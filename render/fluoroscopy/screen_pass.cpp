#include "render/fluoroscopy/screen_pass.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/fluoroscopy/fluoroscopy_shared.h"
#include "render/fluoroscopy/tone.h"
#include "render/gpu/image_states.h"
#include "render/gpu/pipelines.h"
#include "render/shaders.h"

namespace stylet::render {
namespace {

constexpr std::array kScreenBindings{vk::DescriptorType::eUniformBuffer, vk::DescriptorType::eStorageBuffer,
                                     vk::DescriptorType::eStorageBuffer, vk::DescriptorType::eStorageBuffer};

}  // namespace

ScreenPass::ScreenPass(const Gpu& gpu)
    : gpu_(&gpu),
      descriptors_(gpu, kScreenBindings, {}),
      pipeline_(makeComputePipeline(gpu, descriptors_.layout(), shaders::kFluoroscopyScreen, {})),
      uniforms_(gpu, sizeof(gpu::ScreenUniforms), vk::BufferUsageFlagBits::eUniformBuffer),
      slow_(gpu, sizeof(float) * gpu::kMeter * gpu::kMeter, vk::BufferUsageFlagBits::eStorageBuffer),
      smoothed_(std::size_t(gpu::kMeter * gpu::kMeter)),
      scratch_(smoothed_.size()) {}

void ScreenPass::reserve(int pixels) {
    if (pixels_ == pixels) return;
    picture_ = Buffer(*gpu_, sizeof(std::uint32_t) * vk::DeviceSize(pixels) * vk::DeviceSize(pixels),
                      vk::BufferUsageFlagBits::eStorageBuffer);
    pixels_ = pixels;
    paths_ = nullptr;
}

void ScreenPass::prepare(const Buffer& paths, int pixels) {
    reserve(pixels);
    if (paths_ == *paths.handle) return;
    descriptors_.bind(0, uniforms_);
    descriptors_.bind(1, paths);
    descriptors_.bind(2, slow_);
    descriptors_.bind(3, picture_);
    descriptors_.update();
    paths_ = *paths.handle;
}

void ScreenPass::setTone(std::span<const float> meter, int side) {
    const std::span<float> smoothed(smoothed_.data(), std::size_t(side) * std::size_t(side));
    for (int row = 0; row < side; ++row)
        std::copy_n(&meter[std::size_t(row * gpu::kMeter)], side, &smoothed[std::size_t(row * side)]);
    smoothOpen(smoothed, side, scratch_);
    slow_.write(smoothed.data(), smoothed.size_bytes());
    tone_side_ = side;
}

void ScreenPass::record(const vk::raii::CommandBuffer& commands, const Exposure& exposure,
                        const Collimation& c, const FluoroscopySettings& settings, std::int64_t pulse) {
    const double mid_grey = std::max(exposure.quanta_per_pixel * exposure.transmission, 1.0);
    const gpu::ScreenUniforms u{
        .quanta = glm::vec4(exposure.quanta_per_pixel, settings.electronic_quanta, mid_grey, settings.curve),
        .blades = glm::vec4(c.left_m, c.right_m, c.up_m, c.down_m),
        .iris = glm::vec4(c.iris_m.value_or(0.0), settings.detector_m / pixels_, pixels_,
                          settings.dense_is_dark ? 1.0 : 0.0),
        .tone = glm::vec4(settings.flattening, -std::log(exposure.transmission), gpu::meterStride(pixels_),
                          tone_side_),
        .noise =
            glm::uvec4(std::uint32_t(pulse), std::uint32_t(std::uint64_t(pulse) >> 32), settings.seed, 0u)};
    uniforms_.write(&u, sizeof u);
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline_);
    descriptors_.use(commands, vk::PipelineBindPoint::eCompute);
    const std::uint32_t groups = groupCount(pixels_, gpu::kXrayGroup);
    commands.dispatch(groups, groups, 1);
    memoryBarrier(commands, kComputeWrites, kHostReads);
    ++revision_;
}

void ScreenPass::showBlack(int pixels) {
    reserve(pixels);
    std::fill_n(static_cast<std::uint32_t*>(picture_.mapped), std::size_t(pixels) * std::size_t(pixels),
                0xff000000u);
    ++revision_;
}

ScreenPicture ScreenPass::picture() const {
    return {pixels_, pixels_, static_cast<const std::uint8_t*>(picture_.mapped), revision_};
}

}  // namespace stylet::render
