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
constexpr int kGroup = 64;
constexpr auto kImage = vk::DescriptorType::eCombinedImageSampler;
constexpr std::array kBindings{kImage, kImage, vk::DescriptorType::eStorageBuffer, kImage};

struct Push {
    render::ToImage deformation, tool;
    std::uint32_t count = 0;
};

}  // namespace

std::vector<Vec3> referenceOnGpu(const Gpu& gpu, render::DeformedPatient& patient,
                                 const std::vector<Vec3>& deformed_m) {
    std::vector<glm::vec4> points;
    for (const Vec3& p : deformed_m)
        points.emplace_back(glm::vec3(p), 0.0f);
    const render::Buffer list =
        render::makeFilledBuffer(gpu, points, vk::BufferUsageFlagBits::eStorageBuffer);
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
        descriptors.use(commands, vk::PipelineBindPoint::eCompute);
        commands.pushConstants<Push>(descriptors.layout(), kCompute, 0, push);
        commands.dispatch(render::groupCount(int(push.count), kGroup), 1, 1);
    });
    std::memcpy(points.data(), list.mapped, points.size() * sizeof points[0]);
    std::vector<Vec3> found;
    for (const glm::vec4& p : points)
        found.emplace_back(glm::vec3(p));
    return found;
}

}  // namespace stylet::test
