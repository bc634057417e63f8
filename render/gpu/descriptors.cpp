#include "render/gpu/descriptors.h"

namespace stylet::render {
namespace {

vk::raii::DescriptorSetLayout makeSetLayout(const Gpu& gpu, std::span<const vk::DescriptorType> types) {
    std::vector<vk::DescriptorSetLayoutBinding> bindings;
    for (const vk::DescriptorType type : types)
        bindings.push_back({.binding = std::uint32_t(bindings.size()),
                            .descriptorType = type,
                            .descriptorCount = 1,
                            .stageFlags = vk::ShaderStageFlagBits::eVertex |
                                          vk::ShaderStageFlagBits::eFragment |
                                          vk::ShaderStageFlagBits::eCompute});
    return gpu.device().createDescriptorSetLayout(
        {.bindingCount = std::uint32_t(bindings.size()), .pBindings = bindings.data()});
}

vk::raii::DescriptorPool makePool(const Gpu& gpu, std::span<const vk::DescriptorType> types) {
    std::vector<vk::DescriptorPoolSize> sizes;
    for (const vk::DescriptorType type : types)
        sizes.push_back({type, 1});
    return gpu.device().createDescriptorPool({.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                              .maxSets = 1,
                                              .poolSizeCount = std::uint32_t(sizes.size()),
                                              .pPoolSizes = sizes.data()});
}

vk::raii::PipelineLayout makeLayout(const Gpu& gpu, const vk::DescriptorSetLayout& set,
                                    const vk::PushConstantRange& push) {
    return gpu.device().createPipelineLayout({.setLayoutCount = 1,
                                              .pSetLayouts = &set,
                                              .pushConstantRangeCount = push.size > 0 ? 1u : 0u,
                                              .pPushConstantRanges = &push});
}

}  // namespace

Descriptors::Descriptors(const Gpu& gpu, std::span<const vk::DescriptorType> types,
                         vk::PushConstantRange push)
    : gpu_(&gpu),
      set_layout_(makeSetLayout(gpu, types)),
      pool_(makePool(gpu, types)),
      layout_(makeLayout(gpu, *set_layout_, push)),
      buffers_(types.size()),
      images_(types.size()) {
    set_ =
        std::move(gpu.device()
                      .allocateDescriptorSets(
                          {.descriptorPool = *pool_, .descriptorSetCount = 1, .pSetLayouts = &*set_layout_})
                      .front());
    for (std::uint32_t i = 0; i < types.size(); ++i)
        writes_.push_back({.dstSet = *set_,
                           .dstBinding = i,
                           .descriptorCount = 1,
                           .descriptorType = types[i],
                           .pImageInfo = &images_[i],
                           .pBufferInfo = &buffers_[i]});
}

void Descriptors::bindBuffer(std::size_t binding, const Buffer& buffer) {
    buffers_.at(binding) = vk::DescriptorBufferInfo{*buffer.handle, 0, VK_WHOLE_SIZE};
}

void Descriptors::bindImage(std::size_t binding, const GpuImage& image, vk::Sampler sampler,
                            vk::ImageLayout layout) {
    images_.at(binding) = vk::DescriptorImageInfo{sampler, *image.view, layout};
}

void Descriptors::update() {
    gpu_->device().updateDescriptorSets(writes_, {});
}

}  // namespace stylet::render
