#include "tests/render/volume/deform_points.h"

#include <array>
#include <cstring>

#include "render/gpu/descriptors.h"
#include "render/gpu/pipelines.h"

namespace stylet::test {
namespace {

using render::Gpu;

constexpr std::uint32_t kShader[] =
#include "tests/render/volume/deform_points.inc"
    ;
constexpr std::uint32_t kGroup = 64;
constexpr auto kImage = vk::DescriptorType::eCombinedImageSampler;
constexpr std::array kBindings{kImage, kImage, vk::DescriptorType::eStorageBuffer, kImage};

struct Push {
    render::DeformedPatient::ToImage deformation, tool;
    std::uint32_t count = 0;
};

}  // namespace

std::vector<Vec3> referenceOnGpu(const Gpu& gpu, render::DeformedPatient& patient,
                                 const std::vector<Vec3>& deformed_m) {
    std::vector<glm::vec4> points;
    for (const Vec3& p : deformed_m)
        points.emplace_back(glm::vec3(p), 0.0f);
    render::Buffer list(gpu, points.size() * sizeof points[0], vk::BufferUsageFlagBits::eStorageBuffer);
    list.write(points.data(), points.size() * sizeof points[0]);
    const vk::raii::Sampler sampler =
        render::makeSampler(gpu, vk::Filter::eLinear, vk::SamplerAddressMode::eClampToEdge);
    constexpr auto kCompute = vk::ShaderStageFlagBits::eCompute;
    render::Descriptors descriptors(gpu, kBindings, {kCompute, 0, sizeof(Push)});
    descriptors.bind(0, patient.inside(), sampler);
    descriptors.bind(1, patient.outside(), sampler);
    descriptors.bind(2, list);
    descriptors.bind(3, patient.toolMoved(), sampler);
    descriptors.update();
    const vk::raii::Pipeline pipeline = render::makeComputePipeline(gpu, descriptors.layout(), kShader, {});
    const Push push{patient.toDeformation(), patient.toTool(), std::uint32_t(points.size())};
    render::submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
        patient.recordUploads(commands);
        commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
        commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, descriptors.layout(), 0,
                                    descriptors.set(), {});
        commands.pushConstants<Push>(descriptors.layout(), kCompute, 0, push);
        commands.dispatch((push.count + kGroup - 1) / kGroup, 1, 1);
    });
    std::memcpy(points.data(), list.mapped, points.size() * sizeof points[0]);
    std::vector<Vec3> found;
    for (const glm::vec4& p : points)
        found.emplace_back(glm::vec3(p));
    return found;
}

}  // namespace stylet::test
