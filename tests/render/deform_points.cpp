#include "tests/render/deform_points.h"

#include <array>
#include <cstring>

#include "render/memory.h"
#include "render/uniforms.h"

namespace stylet::test {

namespace {

using render::Gpu;
using render::PatientVolume;
using render::Vec3;

constexpr std::uint32_t kShader[] =
#include "tests/render/deform_points.inc"
    ;
constexpr std::uint32_t kGroup = 64;

struct Push {
    glm::vec4 scale, offset;
    std::uint32_t count = 0;
};

// As the renderer samples its tables.
vk::raii::Sampler makeSampler(const Gpu& gpu) {
    constexpr auto edge = vk::SamplerAddressMode::eClampToEdge;
    return gpu.device().createSampler({.magFilter = vk::Filter::eLinear,
                                       .minFilter = vk::Filter::eLinear,
                                       .addressModeU = edge,
                                       .addressModeV = edge,
                                       .addressModeW = edge});
}

vk::raii::DescriptorSetLayout makeLayout(const Gpu& gpu) {
    std::array<vk::DescriptorSetLayoutBinding, 3> bindings;
    for (std::uint32_t i = 0; i < 3; ++i)
        bindings[i] = {.binding = i,
                       .descriptorType = i < 2 ? vk::DescriptorType::eCombinedImageSampler
                                               : vk::DescriptorType::eStorageBuffer,
                       .descriptorCount = 1,
                       .stageFlags = vk::ShaderStageFlagBits::eCompute};
    return gpu.device().createDescriptorSetLayout(
        {.bindingCount = std::uint32_t(bindings.size()), .pBindings = bindings.data()});
}

// The shader with all that it needs, for one list.
struct Run {
    Run(const Gpu& gpu, const PatientVolume& volume, std::size_t points)
        : sampler(makeSampler(gpu)),
          set_layout(makeLayout(gpu)),
          list(gpu, points * sizeof(glm::vec4), vk::BufferUsageFlagBits::eStorageBuffer) {
        const std::array sizes{vk::DescriptorPoolSize{vk::DescriptorType::eCombinedImageSampler, 2},
                               vk::DescriptorPoolSize{vk::DescriptorType::eStorageBuffer, 1}};
        pool =
            gpu.device().createDescriptorPool({.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               .maxSets = 1,
                                               .poolSizeCount = std::uint32_t(sizes.size()),
                                               .pPoolSizes = sizes.data()});
        set =
            std::move(gpu.device()
                          .allocateDescriptorSets(
                              {.descriptorPool = *pool, .descriptorSetCount = 1, .pSetLayouts = &*set_layout})
                          .front());
        const std::array images{
            vk::DescriptorImageInfo{*sampler, *volume.inside().view, vk::ImageLayout::eShaderReadOnlyOptimal},
            vk::DescriptorImageInfo{*sampler, *volume.outside().view,
                                    vk::ImageLayout::eShaderReadOnlyOptimal}};
        const vk::DescriptorBufferInfo buffer{*list.handle, 0, VK_WHOLE_SIZE};
        gpu.device().updateDescriptorSets(
            {vk::WriteDescriptorSet{.dstSet = *set,
                                    .dstBinding = 0,
                                    .descriptorCount = 1,
                                    .descriptorType = vk::DescriptorType::eCombinedImageSampler,
                                    .pImageInfo = &images[0]},
             vk::WriteDescriptorSet{.dstSet = *set,
                                    .dstBinding = 1,
                                    .descriptorCount = 1,
                                    .descriptorType = vk::DescriptorType::eCombinedImageSampler,
                                    .pImageInfo = &images[1]},
             vk::WriteDescriptorSet{.dstSet = *set,
                                    .dstBinding = 2,
                                    .descriptorCount = 1,
                                    .descriptorType = vk::DescriptorType::eStorageBuffer,
                                    .pBufferInfo = &buffer}},
            {});
        const vk::PushConstantRange range{vk::ShaderStageFlagBits::eCompute, 0, sizeof(Push)};
        layout = gpu.device().createPipelineLayout({.setLayoutCount = 1,
                                                    .pSetLayouts = &*set_layout,
                                                    .pushConstantRangeCount = 1,
                                                    .pPushConstantRanges = &range});
        const vk::raii::ShaderModule module =
            gpu.device().createShaderModule({.codeSize = sizeof kShader, .pCode = kShader});
        pipeline = gpu.device().createComputePipeline(
            nullptr,
            {.stage = {.stage = vk::ShaderStageFlagBits::eCompute, .module = *module, .pName = "main"},
             .layout = *layout});
    }

    vk::raii::Sampler sampler;
    vk::raii::DescriptorSetLayout set_layout;
    render::Buffer list;
    vk::raii::DescriptorPool pool = nullptr;
    vk::raii::DescriptorSet set = nullptr;
    vk::raii::PipelineLayout layout = nullptr;
    vk::raii::Pipeline pipeline = nullptr;
};

}  // namespace

std::vector<Vec3> referenceOnGpu(const Gpu& gpu, const PatientVolume& volume,
                                 const std::vector<Vec3>& deformed_m) {
    Run run(gpu, volume, deformed_m.size());
    std::vector<glm::vec4> points;
    for (const Vec3& p : deformed_m)
        points.emplace_back(glm::vec3(p), 0.0f);
    run.list.write(points.data(), points.size() * sizeof points[0]);
    const render::gpu::FrameUniforms frame =
        render::frameUniforms({}, {}, {}, 1, 1, &volume, render::LookStyle{});
    const Push push{frame.deform_scale, frame.deform_offset, std::uint32_t(points.size())};
    render::submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
        commands.bindPipeline(vk::PipelineBindPoint::eCompute, *run.pipeline);
        commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *run.layout, 0, *run.set, {});
        commands.pushConstants<Push>(*run.layout, vk::ShaderStageFlagBits::eCompute, 0, push);
        commands.dispatch((push.count + kGroup - 1) / kGroup, 1, 1);
    });
    std::memcpy(points.data(), run.list.mapped, points.size() * sizeof points[0]);
    std::vector<Vec3> found;
    for (const glm::vec4& p : points)
        found.emplace_back(glm::vec3(p));
    return found;
}

}  // namespace stylet::test
