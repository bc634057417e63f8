// A descriptor set and the pipeline layout that goes with it.
#pragma once

#include <span>
#include <vector>

#include "render/gpu/memory.h"

namespace stylet::render {

class Descriptors {
  public:
    // Bindings 0, 1, ... of set 0, visible to every stage.
    Descriptors(const Gpu&, std::span<const vk::DescriptorType> bindings, vk::PushConstantRange push);

    // `binding`: the binding's number, or an enumerator with that value. The bound resource must stay alive
    // until the next update(). Every binding must be bound once before the first update(): lavapipe of Mesa
    // 22.3 reads all of them.
    template <typename Number>
    void bind(Number binding, const Buffer& buffer) {
        bindBuffer(std::size_t(binding), buffer);
    }
    template <typename Number>
    void bind(Number binding, const GpuImage& image, const vk::raii::Sampler& sampler) {
        bindImage(std::size_t(binding), image, *sampler, vk::ImageLayout::eShaderReadOnlyOptimal);
    }
    template <typename Number>
    void bindStorage(Number binding, const GpuImage& image) {  // the image is in GENERAL layout
        bindImage(std::size_t(binding), image, {}, vk::ImageLayout::eGeneral);
    }
    // Must not be called while commands that use the set are in flight.
    void update();

    // Binds the set to a command buffer.
    void use(const vk::raii::CommandBuffer& commands, vk::PipelineBindPoint point) const {
        commands.bindDescriptorSets(point, *layout_, 0, *set_, {});
    }
    const vk::PipelineLayout& layout() const { return *layout_; }

  private:
    void bindBuffer(std::size_t binding, const Buffer&);
    void bindImage(std::size_t binding, const GpuImage&, vk::Sampler, vk::ImageLayout);

    const Gpu* gpu_;
    vk::raii::DescriptorSetLayout set_layout_;
    vk::raii::DescriptorPool pool_;
    vk::raii::DescriptorSet set_ = nullptr;
    vk::raii::PipelineLayout layout_;
    std::vector<vk::DescriptorBufferInfo> buffers_;
    std::vector<vk::DescriptorImageInfo> images_;
    std::vector<vk::WriteDescriptorSet> writes_;
};

}  // namespace stylet::render
