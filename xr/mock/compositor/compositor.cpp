#include "compositor/compositor.h"

#include <algorithm>

#include "compositor/shaders.h"

namespace xrmock {

namespace {

constexpr VkFormat kLinearFormat = VK_FORMAT_R16G16B16A16_SFLOAT;  // every GPU can blend it
constexpr VkFormat kEncodedFormat = VK_FORMAT_R8G8B8A8_SRGB;       // the blit encodes to sRGB

template <std::size_t kCount>
ShaderModule shaderModule(const VulkanDevice& device, const std::uint32_t (&words)[kCount]) {
    const VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, nullptr, 0, sizeof words,
                                        words};
    return {device, device.vkCreateShaderModule, info, "vkCreateShaderModule"};
}

DescriptorSetLayout makeSetLayout(const VulkanDevice& device) {
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 1,
                                               VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    const VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr,
                                               0, 1, &binding};
    return {device, device.vkCreateDescriptorSetLayout, info, "vkCreateDescriptorSetLayout"};
}

DescriptorPool makePool(const VulkanDevice& device) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, kMaxLayers};
    const VkDescriptorPoolCreateInfo info{
        VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, kMaxLayers, 1, &size};
    return {device, device.vkCreateDescriptorPool, info, "vkCreateDescriptorPool"};
}

PipelineLayout makePipelineLayout(const VulkanDevice& device, const DescriptorSetLayout& set_layout) {
    const VkPushConstantRange constants{VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(PaintConstants)};
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = 1;
    info.pSetLayouts = set_layout.address();
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &constants;
    return {device, device.vkCreatePipelineLayout, info, "vkCreatePipelineLayout"};
}

// The pass clears the image to transparent black and leaves it in the layout for copying.
RenderPass makeRenderPass(const VulkanDevice& device) {
    VkAttachmentDescription colour{};
    colour.format = kLinearFormat;
    colour.samples = VK_SAMPLE_COUNT_1_BIT;
    colour.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    colour.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    colour.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    colour.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    colour.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    colour.finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    // Needs no dependency on earlier compositions, because the host has waited for them.
    const VkSubpassDependency to_copy{0,
                                      VK_SUBPASS_EXTERNAL,
                                      VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                      VK_PIPELINE_STAGE_TRANSFER_BIT,
                                      VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                      VK_ACCESS_TRANSFER_READ_BIT,
                                      0};
    VkRenderPassCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
    info.attachmentCount = 1;
    info.pAttachments = &colour;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 1;
    info.pDependencies = &to_copy;
    return {device, device.vkCreateRenderPass, info, "vkCreateRenderPass"};
}

// The pipelines differ only in the shader's kLayerType.
Pipeline makePipeline(const VulkanDevice& device, const PipelineLayout& layout, const RenderPass& pass,
                      LayerType type) {
    const ShaderModule vertex = shaderModule(device, kVertexShader);
    const ShaderModule fragment = shaderModule(device, kFragmentShader);
    const auto layer_type = static_cast<std::int32_t>(type);
    const VkSpecializationMapEntry entry{0, 0, sizeof layer_type};
    const VkSpecializationInfo constants{1, &entry, sizeof layer_type, &layer_type};
    const VkPipelineShaderStageCreateInfo stages[] = {
        {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_VERTEX_BIT, vertex,
         "main", nullptr},
        {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_FRAGMENT_BIT,
         fragment, "main", &constants}};
    VkPipelineVertexInputStateCreateInfo no_vertices{};
    no_vertices.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    const VkPipelineInputAssemblyStateCreateInfo triangles{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO, nullptr, 0,
        VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_FALSE};
    const VkPipelineViewportStateCreateInfo viewport{
        VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, nullptr, 0, 1, nullptr, 1, nullptr};
    VkPipelineRasterizationStateCreateInfo raster{};
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{};
    samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    // OpenXR, "Composition Layer Blending": layer + painted * (1 - layer.a). Alpha is blended the same way.
    const VkPipelineColorBlendAttachmentState over{VK_TRUE,
                                                   VK_BLEND_FACTOR_ONE,
                                                   VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
                                                   VK_BLEND_OP_ADD,
                                                   VK_BLEND_FACTOR_ONE,
                                                   VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
                                                   VK_BLEND_OP_ADD,
                                                   VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                       VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
    VkPipelineColorBlendStateCreateInfo blend{};
    blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blend.attachmentCount = 1;
    blend.pAttachments = &over;
    const VkDynamicState dynamics[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    const VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                   nullptr, 0, 2, dynamics};
    VkGraphicsPipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &no_vertices;
    info.pInputAssemblyState = &triangles;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = layout;
    info.renderPass = pass;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(device.vkCreateGraphicsPipelines(device.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateGraphicsPipelines");
    return {device, pipeline};
}

// A swapchain image read by one composition.
struct Sampled {
    const SwapchainImages* images;
    std::uint32_t index;
    DeviceImage resolved;  // resolved copy of a multisampled image, sampled instead of it
    ImageView view;

    bool isMultisampled() const { return images->samples > 1; }
};

Sampled makeSampled(const VulkanDevice& device, const SwapchainImages& images, std::uint32_t index) {
    Sampled sampled{&images, index, {}, {}};
    VkImage image = images.images[index].image;
    if (sampled.isMultisampled()) {
        sampled.resolved =
            makeTarget(device, images.format, {images.width, images.height},
                       VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, images.layers);
        image = sampled.resolved.image;
    }
    sampled.view = arrayView(device, image, images.format, VK_IMAGE_USAGE_SAMPLED_BIT);
    return sampled;
}

// How commands use an image. A barrier leads from one use to the next.
struct Use {
    VkPipelineStageFlags stage;
    VkAccessFlags access;
    VkImageLayout layout;
};
constexpr Use kUndefined{VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr Use kCopyTarget{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                          VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
constexpr Use kCopySource{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT,
                          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
constexpr Use kSampled{VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT,
                       VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

// Records the layout transitions of the images for reading. If `back` is set, records the reverse ones.
void recordLayoutChanges(const VulkanDevice& device, VkCommandBuffer commands,
                         const std::vector<Sampled>& sampled, bool back) {
    std::vector<VkImageMemoryBarrier> barriers;
    for (const Sampled& each : sampled) {
        const Use& use = each.isMultisampled() ? kCopySource : kSampled;
        VkImageMemoryBarrier barrier =
            imageBarrier(each.images->images[each.index].image, imageAspect(each.images->format));
        barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
        barrier.dstAccessMask = use.access;
        barrier.oldLayout = each.images->restingLayout();
        barrier.newLayout = use.layout;
        if (back) {
            barrier.srcAccessMask = 0;
            barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
            std::swap(barrier.oldLayout, barrier.newLayout);
        }
        barriers.push_back(barrier);
    }
    const VkPipelineStageFlags application = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkPipelineStageFlags compositor = kSampled.stage | kCopySource.stage;
    device.vkCmdPipelineBarrier(commands, back ? compositor : application, back ? application : compositor, 0,
                                0, nullptr, 0, nullptr, static_cast<std::uint32_t>(barriers.size()),
                                barriers.data());
}

void recordTransition(const VulkanDevice& device, VkCommandBuffer commands, VkImage image, const Use& from,
                      const Use& to) {
    VkImageMemoryBarrier barrier = imageBarrier(image, VK_IMAGE_ASPECT_COLOR_BIT);
    barrier.srcAccessMask = from.access;
    barrier.dstAccessMask = to.access;
    barrier.oldLayout = from.layout;
    barrier.newLayout = to.layout;
    device.vkCmdPipelineBarrier(commands, from.stage, to.stage, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

void recordResolve(const VulkanDevice& device, VkCommandBuffer commands, const Sampled& sampled) {
    const SwapchainImages& images = *sampled.images;
    recordTransition(device, commands, sampled.resolved.image, kUndefined, kCopyTarget);
    const VkImageSubresourceLayers all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, images.layers};
    const VkImageResolve region{all, {0, 0, 0}, all, {0, 0, 0}, {images.width, images.height, 1}};
    device.vkCmdResolveImage(commands, images.images[sampled.index].image, kCopySource.layout,
                             sampled.resolved.image, kCopyTarget.layout, 1, &region);
    recordTransition(device, commands, sampled.resolved.image, kCopyTarget, kSampled);
}

}  // namespace

void Compositor::prepare(const VulkanDevice& device) {
    if (pass_ != VK_NULL_HANDLE) return;
    set_layout_ = makeSetLayout(device);
    descriptors_ = makePool(device);
    layout_ = makePipelineLayout(device, set_layout_);
    pass_ = makeRenderPass(device);
}

void Compositor::prepareTargets(const VulkanDevice& device, VkExtent2D size) {
    if (targets_.size.width == size.width && targets_.size.height == size.height) return;
    targets_ = {};
    targets_.linear = makeTarget(device, kLinearFormat, size,
                                 VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    targets_.encoded = makeTarget(device, kEncodedFormat, size,
                                  VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    targets_.linear_view =
        arrayView(device, targets_.linear.image, kLinearFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    VkFramebufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
    info.renderPass = pass_;
    info.attachmentCount = 1;
    info.pAttachments = targets_.linear_view.address();
    info.width = size.width;
    info.height = size.height;
    info.layers = 1;
    targets_.framebuffer = Framebuffer(device, device.vkCreateFramebuffer, info, "vkCreateFramebuffer");
    targets_.readback = ReadbackBuffer(device, VkDeviceSize{size.width} * size.height * 4);
    targets_.size = size;
}

VkPipeline Compositor::pipelineFor(const VulkanDevice& device, LayerType type) {
    Pipeline& pipeline = pipelines_[static_cast<std::size_t>(type)];
    if (pipeline == VK_NULL_HANDLE) pipeline = makePipeline(device, layout_, pass_, type);
    return pipeline;
}

VkDescriptorSet Compositor::descriptorSet(const VulkanDevice& device, VkImageView view) {
    const VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr,
                                           descriptors_, 1, set_layout_.address()};
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(device.vkAllocateDescriptorSets(device.device, &info, &set), "vkAllocateDescriptorSets");
    const VkDescriptorImageInfo image{VK_NULL_HANDLE, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
    write.pImageInfo = &image;
    device.vkUpdateDescriptorSets(device.device, 1, &write, 0, nullptr);
    return set;
}

void Compositor::drawLayers(const VulkanDevice& device, VkCommandBuffer commands,
                            const std::vector<Paint>& layers,
                            const std::vector<VkDescriptorSet>& sets) const {
    const VkRect2D area{{0, 0}, targets_.size};
    const VkClearValue transparent_black{};
    const VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                      nullptr,
                                      pass_,
                                      targets_.framebuffer,
                                      area,
                                      1,
                                      &transparent_black};
    device.vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    const VkViewport viewport{
        0, 0, static_cast<float>(area.extent.width), static_cast<float>(area.extent.height), 0, 1};
    device.vkCmdSetViewport(commands, 0, 1, &viewport);
    device.vkCmdSetScissor(commands, 0, 1, &area);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        device.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS,
                                 pipelines_[static_cast<std::size_t>(layers[i].type)]);
        device.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &sets[i], 0,
                                       nullptr);
        device.vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(PaintConstants),
                                  &layers[i].constants);
        device.vkCmdDraw(commands, 3, 1, 0, 0);
    }
    device.vkCmdEndRenderPass(commands);
}

void Compositor::readBack(const VulkanDevice& device, VkCommandBuffer commands) const {
    recordTransition(device, commands, targets_.encoded.image, kUndefined, kCopyTarget);
    const VkImageSubresourceLayers whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    const VkOffset3D end{static_cast<std::int32_t>(targets_.size.width),
                         static_cast<std::int32_t>(targets_.size.height), 1};
    const VkImageBlit encode{whole, {{0, 0, 0}, end}, whole, {{0, 0, 0}, end}};
    device.vkCmdBlitImage(commands, targets_.linear.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                          targets_.encoded.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &encode,
                          VK_FILTER_NEAREST);
    recordTransition(device, commands, targets_.encoded.image, kCopyTarget, kCopySource);
    VkBufferImageCopy region{};
    region.imageSubresource = whole;
    region.imageExtent = {targets_.size.width, targets_.size.height, 1};
    device.vkCmdCopyImageToBuffer(commands, targets_.encoded.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                  targets_.readback.buffer, 1, &region);
    const VkMemoryBarrier to_host{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT,
                                  VK_ACCESS_HOST_READ_BIT};
    device.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                                &to_host, 0, nullptr, 0, nullptr);
}

Picture Compositor::paint(VulkanDevice& device, const std::vector<Paint>& layers, VkExtent2D size) {
    prepare(device);
    prepareTargets(device, size);
    check(device.vkResetDescriptorPool(device.device, descriptors_, 0), "vkResetDescriptorPool");
    std::vector<Sampled> sampled;  // each image once
    std::vector<VkDescriptorSet> sets;
    for (const Paint& layer : layers) {
        pipelineFor(device, layer.type);
        auto known = std::find_if(sampled.begin(), sampled.end(), [&](const Sampled& each) {
            return each.images == layer.images && each.index == layer.image;
        });
        if (known == sampled.end()) {
            sampled.push_back(makeSampled(device, *layer.images, layer.image));
            known = sampled.end() - 1;
        }
        sets.push_back(descriptorSet(device, known->view));
    }
    device.submitAndWait([&](VkCommandBuffer commands) {
        if (!sampled.empty()) recordLayoutChanges(device, commands, sampled, false);
        for (const Sampled& each : sampled)
            if (each.isMultisampled()) recordResolve(device, commands, each);
        drawLayers(device, commands, layers, sets);
        if (!sampled.empty()) recordLayoutChanges(device, commands, sampled, true);
        readBack(device, commands);
    });
    return {size.width, size.height, targets_.readback.bytes(device)};
}

}  // namespace xrmock
