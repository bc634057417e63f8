#include "render/gpu/pipelines.h"

#include <array>
#include <vector>

namespace stylet::render {
namespace {

vk::raii::ShaderModule makeModule(const Gpu& gpu, std::span<const std::uint32_t> words) {
    return gpu.device().createShaderModule({.codeSize = words.size_bytes(), .pCode = words.data()});
}

// 32-bit specialisation constants 0, 1, ...
struct Specialisation {
    explicit Specialisation(std::span<const std::uint32_t> constants) {
        for (std::uint32_t i = 0; i < constants.size(); ++i)
            entries.push_back({.constantID = i, .offset = i * 4, .size = 4});
        info = {.mapEntryCount = std::uint32_t(entries.size()),
                .pMapEntries = entries.data(),
                .dataSize = constants.size_bytes(),
                .pData = constants.data()};
    }
    Specialisation(const Specialisation&) = delete;
    Specialisation& operator=(const Specialisation&) = delete;

    std::vector<vk::SpecializationMapEntry> entries;
    vk::SpecializationInfo info;
};

vk::PipelineColorBlendAttachmentState blendState(Blend blend) {
    using Mask = vk::ColorComponentFlagBits;
    return {.blendEnable = blend == Blend::over,
            .srcColorBlendFactor = vk::BlendFactor::eOne,
            .dstColorBlendFactor = vk::BlendFactor::eOneMinusSrcAlpha,
            .colorBlendOp = vk::BlendOp::eAdd,
            .srcAlphaBlendFactor = vk::BlendFactor::eOne,
            .dstAlphaBlendFactor = vk::BlendFactor::eOneMinusSrcAlpha,
            .alphaBlendOp = vk::BlendOp::eAdd,
            .colorWriteMask = Mask::eR | Mask::eG | Mask::eB | Mask::eA};
}

}  // namespace

vk::raii::Pipeline makePipeline(const Gpu& gpu, vk::PipelineLayout layout, const PipelineShape& shape) {
    const auto vertex = makeModule(gpu, shape.vertex), fragment = makeModule(gpu, shape.fragment);
    const Specialisation specialisation(shape.constants);
    const std::array stages{
        vk::PipelineShaderStageCreateInfo{
            .stage = vk::ShaderStageFlagBits::eVertex, .module = *vertex, .pName = "main"},
        vk::PipelineShaderStageCreateInfo{.stage = vk::ShaderStageFlagBits::eFragment,
                                          .module = *fragment,
                                          .pName = "main",
                                          .pSpecializationInfo = &specialisation.info}};
    const vk::VertexInputBindingDescription binding{.binding = 0, .stride = shape.vertex_stride};
    const vk::PipelineVertexInputStateCreateInfo vertex_input{
        .vertexBindingDescriptionCount = shape.attributes.empty() ? 0u : 1u,
        .pVertexBindingDescriptions = &binding,
        .vertexAttributeDescriptionCount = std::uint32_t(shape.attributes.size()),
        .pVertexAttributeDescriptions = shape.attributes.data()};
    const vk::PipelineInputAssemblyStateCreateInfo assembly{.topology = vk::PrimitiveTopology::eTriangleList};
    const vk::PipelineViewportStateCreateInfo viewport{.viewportCount = 1, .scissorCount = 1};
    const vk::PipelineRasterizationStateCreateInfo raster{
        .polygonMode = vk::PolygonMode::eFill,
        .cullMode = shape.cull_back ? vk::CullModeFlagBits::eBack : vk::CullModeFlagBits::eNone,
        .frontFace = vk::FrontFace::eCounterClockwise,
        .lineWidth = 1.0f};
    const vk::PipelineMultisampleStateCreateInfo samples{.rasterizationSamples = vk::SampleCountFlagBits::e1};
    const vk::PipelineDepthStencilStateCreateInfo depth{
        .depthTestEnable = shape.depth_use != DepthUse::none,
        .depthWriteEnable = shape.depth_use == DepthUse::test_and_write || shape.depth_use == DepthUse::write,
        .depthCompareOp =
            shape.depth_use == DepthUse::write ? vk::CompareOp::eAlways : vk::CompareOp::eGreaterOrEqual};
    const auto attachment = blendState(shape.blend);
    const std::uint32_t colours = shape.colour == vk::Format::eUndefined ? 0 : 1;
    const vk::PipelineColorBlendStateCreateInfo blend{.attachmentCount = colours,
                                                      .pAttachments = &attachment};
    const std::array dynamic{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
    const vk::PipelineDynamicStateCreateInfo dynamic_state{.dynamicStateCount = std::uint32_t(dynamic.size()),
                                                           .pDynamicStates = dynamic.data()};
    const vk::PipelineRenderingCreateInfo rendering{.viewMask = shape.view_mask,
                                                    .colorAttachmentCount = colours,
                                                    .pColorAttachmentFormats = &shape.colour,
                                                    .depthAttachmentFormat = shape.depth};
    return gpu.pipeline(vk::GraphicsPipelineCreateInfo{.pNext = &rendering,
                                                       .stageCount = std::uint32_t(stages.size()),
                                                       .pStages = stages.data(),
                                                       .pVertexInputState = &vertex_input,
                                                       .pInputAssemblyState = &assembly,
                                                       .pViewportState = &viewport,
                                                       .pRasterizationState = &raster,
                                                       .pMultisampleState = &samples,
                                                       .pDepthStencilState = &depth,
                                                       .pColorBlendState = &blend,
                                                       .pDynamicState = &dynamic_state,
                                                       .layout = layout});
}

vk::raii::Pipeline makeComputePipeline(const Gpu& gpu, vk::PipelineLayout layout,
                                       std::span<const std::uint32_t> shader,
                                       std::span<const std::uint32_t> constants) {
    const auto module = makeModule(gpu, shader);
    const Specialisation specialisation(constants);
    return gpu.pipeline(vk::ComputePipelineCreateInfo{.stage = {.stage = vk::ShaderStageFlagBits::eCompute,
                                                                .module = *module,
                                                                .pName = "main",
                                                                .pSpecializationInfo = &specialisation.info},
                                                      .layout = layout});
}

}  // namespace stylet::render
