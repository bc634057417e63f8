// Vulkan as used by the runtime. Every function is loaded through the application's vkGetInstanceProcAddr;
// the runtime does not link to Vulkan.
#pragma once

#include <cstdint>
#include <vector>

#include "scenario/openxr_api.h"

namespace xrmock {

// A VkInstance known to the runtime: created through xrCreateVulkanInstanceKHR, or passed to
// xrGetVulkanGraphicsDeviceKHR.
struct VulkanInstance {
    VkInstance instance;
    PFN_vkGetInstanceProcAddr getInstanceProcAddr;
    std::uint32_t api_version = VK_API_VERSION_1_0;     // requested API version, if known
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;  // chosen by xrGetVulkanGraphicsDevice(2)KHR
    bool created_by_runtime = true;                     // created through XR_KHR_vulkan_enable2
    std::vector<VkDevice> devices{};                    // devices created through it
};

// Returns vkGetInstanceProcAddr of the Vulkan loader in this process, because XR_KHR_vulkan_enable does not
// pass one. Null if there is none.
PFN_vkGetInstanceProcAddr findVulkanLoader();

// Chooses the GPU: discrete before integrated before others. Null if there is none.
VkPhysicalDevice choosePhysicalDevice(const VulkanInstance& vulkan);

#define XRMOCK_VULKAN_FUNCTIONS(_)   \
    _(vkAllocateCommandBuffers)      \
    _(vkAllocateDescriptorSets)      \
    _(vkAllocateMemory)              \
    _(vkBeginCommandBuffer)          \
    _(vkBindBufferMemory)            \
    _(vkBindImageMemory)             \
    _(vkCmdBeginRenderPass)          \
    _(vkCmdBindDescriptorSets)       \
    _(vkCmdBindPipeline)             \
    _(vkCmdBlitImage)                \
    _(vkCmdCopyImageToBuffer)        \
    _(vkCmdDraw)                     \
    _(vkCmdEndRenderPass)            \
    _(vkCmdPipelineBarrier)          \
    _(vkCmdPushConstants)            \
    _(vkCmdResolveImage)             \
    _(vkCmdSetScissor)               \
    _(vkCmdSetViewport)              \
    _(vkCreateBuffer)                \
    _(vkCreateCommandPool)           \
    _(vkCreateDescriptorPool)        \
    _(vkCreateDescriptorSetLayout)   \
    _(vkCreateFence)                 \
    _(vkCreateFramebuffer)           \
    _(vkCreateGraphicsPipelines)     \
    _(vkCreateImage)                 \
    _(vkCreateImageView)             \
    _(vkCreatePipelineLayout)        \
    _(vkCreateRenderPass)            \
    _(vkCreateShaderModule)          \
    _(vkDestroyBuffer)               \
    _(vkDestroyCommandPool)          \
    _(vkDestroyDescriptorPool)       \
    _(vkDestroyDescriptorSetLayout)  \
    _(vkDestroyFence)                \
    _(vkDestroyFramebuffer)          \
    _(vkDestroyImage)                \
    _(vkDestroyImageView)            \
    _(vkDestroyPipeline)             \
    _(vkDestroyPipelineLayout)       \
    _(vkDestroyRenderPass)           \
    _(vkDestroyShaderModule)         \
    _(vkEndCommandBuffer)            \
    _(vkFreeMemory)                  \
    _(vkGetBufferMemoryRequirements) \
    _(vkGetDeviceQueue)              \
    _(vkGetImageMemoryRequirements)  \
    _(vkMapMemory)                   \
    _(vkQueueSubmit)                 \
    _(vkResetCommandPool)            \
    _(vkResetDescriptorPool)         \
    _(vkResetFences)                 \
    _(vkUnmapMemory)                 \
    _(vkUpdateDescriptorSets)        \
    _(vkWaitForFences)

// The Vulkan device of a session, with one command buffer for the application's queue. Owns the objects
// that the runtime created on the device.
struct VulkanDevice {
    VulkanDevice() = default;
    // Throws Refused on failure.
    VulkanDevice(const VulkanInstance& vulkan, const XrGraphicsBindingVulkanKHR& binding);
    VulkanDevice(const VulkanDevice&) = delete;
    VulkanDevice& operator=(const VulkanDevice&) = delete;
    ~VulkanDevice();

    // Records and submits commands, and waits for the GPU. During the OpenXR call the runtime may use the
    // queue (XR_KHR_vulkan_enable2, "Concurrency").
    template <class Record>
    void submitAndWait(Record record) {
        beginCommands();
        record(commands);
        finishCommands();
    }
    std::uint32_t memoryType(std::uint32_t allowed, VkMemoryPropertyFlags wanted) const;
    bool formatSupports(VkFormat format, VkFormatFeatureFlags features) const;
    // True if an image may have a usage that only views in other formats support (Vulkan 1.1).
    bool hasExtendedUsage() const { return api_version >= VK_API_VERSION_1_1; }

#define XRMOCK_DECLARE(name) PFN_##name name = nullptr;
    XRMOCK_VULKAN_FUNCTIONS(XRMOCK_DECLARE)
#undef XRMOCK_DECLARE
    PFN_vkGetPhysicalDeviceFormatProperties vkGetPhysicalDeviceFormatProperties = nullptr;
    PFN_vkGetPhysicalDeviceImageFormatProperties vkGetPhysicalDeviceImageFormatProperties = nullptr;

    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    VkPhysicalDeviceMemoryProperties memory{};
    std::uint32_t api_version = VK_API_VERSION_1_0;  // the lower of the instance's and the GPU's version

  private:
    void beginCommands();
    void finishCommands();
};

// Throws Refused if the Vulkan call failed.
void check(VkResult result, const char* function);

constexpr std::uint32_t kMaxSampleCount = 4;  // of a swapchain image; every GPU supports 4

// Supported swapchain formats, preferred first.
std::vector<VkFormat> swapchainFormats(const VulkanDevice& device);
bool isDepthFormat(VkFormat format);
VkImageAspectFlags imageAspect(VkFormat format);

}  // namespace xrmock
