// Owning wrappers of Vulkan objects. The device must outlive them.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "compositor/vulkan_device.h"

namespace xrmock {

template <class Handle, auto kDestroy>
class Owned {
  public:
    Owned() = default;
    Owned(const VulkanDevice& device, Handle handle) : device_(&device), handle_(handle) {}
    // Calls a vkCreate function. Throws Refused, naming `function`.
    template <class Info>
    Owned(const VulkanDevice& device,
          VkResult(VKAPI_PTR* create)(VkDevice, const Info*, const VkAllocationCallbacks*, Handle*),
          const Info& info, const char* function)
        : device_(&device) {
        check(create(device.device, &info, nullptr, &handle_), function);
    }
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

// Members are destroyed in reverse order. The constructors throw Refused.

// An image with its memory.
struct DeviceImage {
    DeviceImage() = default;
    DeviceImage(const VulkanDevice& device, const VkImageCreateInfo& info);

    Memory memory;
    Image image;
};
// An image with one mip level.
DeviceImage makeTarget(const VulkanDevice& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
                       std::uint32_t layers = 1);

// A buffer that the GPU writes and the CPU reads.
struct ReadbackBuffer {
    ReadbackBuffer() = default;
    ReadbackBuffer(const VulkanDevice& device, VkDeviceSize size);
    std::vector<std::uint8_t> bytes(const VulkanDevice& device) const;

    VkDeviceSize size = 0;
    Memory memory;
    Buffer buffer;
};

// A 2D array view of all layers of the first mip level. `usage` must be a subset of the image's usages.
ImageView arrayView(const VulkanDevice& device, VkImage image, VkFormat format, VkImageUsageFlags usage);

// The images of a swapchain.
struct SwapchainImages {
    SwapchainImages(const VulkanDevice& device, const XrSwapchainCreateInfo& info, std::uint32_t count);

    // The layout in which the application acquires and releases an image.
    VkImageLayout restingLayout() const;

    VkFormat format;
    std::uint32_t width, height, layers, samples;
    std::vector<DeviceImage> images;
    std::vector<bool> in_resting_layout;  // false: contents and layout are still undefined
};

// Transitions the images that are not yet in the resting layout to it.
void transitionToRestingLayout(VulkanDevice& device, SwapchainImages& swapchain);

// A barrier for all mip levels and array layers. The caller sets accesses and layouts.
VkImageMemoryBarrier imageBarrier(VkImage image, VkImageAspectFlags aspect);

}  // namespace xrmock
