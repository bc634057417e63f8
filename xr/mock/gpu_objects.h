// Vulkan objects that free themselves. The device outlives them.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "vulkan_device.h"

namespace xrmock {

template <class Handle, auto kDestroy>
class Owned {
  public:
    Owned() = default;
    Owned(const VulkanDevice& device, Handle handle) : device_(&device), handle_(handle) {}
    Owned(Owned&& other) noexcept
        : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
    Owned& operator=(Owned&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Owned() {
        if (handle_ != VK_NULL_HANDLE) (device_->*kDestroy)(device_->device, handle_, nullptr);
    }
    operator Handle() const { return handle_; }
    const Handle* address() const { return &handle_; }

  private:
    const VulkanDevice* device_ = nullptr;
    Handle handle_ = VK_NULL_HANDLE;
};

using Buffer = Owned<VkBuffer, &VulkanDevice::vkDestroyBuffer>;
using DescriptorPool = Owned<VkDescriptorPool, &VulkanDevice::vkDestroyDescriptorPool>;
using DescriptorSetLayout = Owned<VkDescriptorSetLayout, &VulkanDevice::vkDestroyDescriptorSetLayout>;
using Framebuffer = Owned<VkFramebuffer, &VulkanDevice::vkDestroyFramebuffer>;
using Image = Owned<VkImage, &VulkanDevice::vkDestroyImage>;
using ImageView = Owned<VkImageView, &VulkanDevice::vkDestroyImageView>;
using Memory = Owned<VkDeviceMemory, &VulkanDevice::vkFreeMemory>;
using Pipeline = Owned<VkPipeline, &VulkanDevice::vkDestroyPipeline>;
using PipelineLayout = Owned<VkPipelineLayout, &VulkanDevice::vkDestroyPipelineLayout>;
using RenderPass = Owned<VkRenderPass, &VulkanDevice::vkDestroyRenderPass>;
using ShaderModule = Owned<VkShaderModule, &VulkanDevice::vkDestroyShaderModule>;

// Members are freed from the last to the first. The constructors throw Refused.

// An image of one level that the GPU draws into and copies from.
struct TargetImage {
    TargetImage() = default;
    TargetImage(const VulkanDevice& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
                std::uint32_t layers = 1);

    Memory memory;
    Image image;
};

// Memory that the GPU fills and the CPU reads.
struct ReadbackBuffer {
    ReadbackBuffer() = default;
    ReadbackBuffer(const VulkanDevice& device, VkDeviceSize size);
    std::vector<std::uint8_t> bytes(const VulkanDevice& device) const;

    VkDeviceSize size = 0;
    Memory memory;
    Buffer buffer;
};

// All layers of the first level, as a 2D array, for a part of the uses that the image has.
ImageView arrayView(const VulkanDevice& device, VkImage image, VkFormat format, VkImageUsageFlags usage);

}  // namespace xrmock
