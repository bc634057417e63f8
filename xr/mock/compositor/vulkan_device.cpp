#include "compositor/vulkan_device.h"

#include <dlfcn.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compositor/refused.h"

namespace xrmock {

namespace {

template <class Function>
Function instanceFunction(const VulkanInstance& vulkan, const char* name) {
    const auto function = reinterpret_cast<Function>(vulkan.getInstanceProcAddr(vulkan.instance, name));
    if (function == nullptr) refuse(XR_ERROR_RUNTIME_FAILURE, std::string(name) + " is missing");
    return function;
}

}  // namespace

void check(VkResult result, const char* function) {
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY)
        refuse(XR_ERROR_OUT_OF_MEMORY, std::string(function) + " is out of memory");
    if (result != VK_SUCCESS)
        refuse(XR_ERROR_RUNTIME_FAILURE, std::string(function) + " returned " + std::to_string(result));
}

VkPhysicalDevice choosePhysicalDevice(const VulkanInstance& vulkan) {
    const auto enumerate =
        instanceFunction<PFN_vkEnumeratePhysicalDevices>(vulkan, "vkEnumeratePhysicalDevices");
    const auto properties_of =
        instanceFunction<PFN_vkGetPhysicalDeviceProperties>(vulkan, "vkGetPhysicalDeviceProperties");
    std::uint32_t count = 0;
    check(enumerate(vulkan.instance, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> devices(count);
    check(enumerate(vulkan.instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
    const auto rank = [&](VkPhysicalDevice device) {
        VkPhysicalDeviceProperties properties;
        properties_of(device, &properties);
        switch (properties.deviceType) {
            case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
                return 0;
            case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
                return 1;
            default:
                return 2;
        }
    };
    const auto best =
        std::min_element(devices.begin(), devices.end(),
                         [&](VkPhysicalDevice a, VkPhysicalDevice b) { return rank(a) < rank(b); });
    return best == devices.end() ? VK_NULL_HANDLE : *best;
}

PFN_vkGetInstanceProcAddr findVulkanLoader() {
    constexpr const char* kName = "vkGetInstanceProcAddr";
    void* found = dlsym(RTLD_DEFAULT, kName);
    if (found == nullptr) {
        // Never closed: the application has loaded it anyway.
        void* library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
        if (library != nullptr) found = dlsym(library, kName);
    }
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(found);
}

namespace {

void checkQueue(const VulkanInstance& vulkan, const XrGraphicsBindingVulkanKHR& binding) {
    const auto families_of = instanceFunction<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(
        vulkan, "vkGetPhysicalDeviceQueueFamilyProperties");
    std::uint32_t count = 0;
    families_of(binding.physicalDevice, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    families_of(binding.physicalDevice, &count, families.data());
    require(binding.queueFamilyIndex < count &&
                binding.queueIndex < families[binding.queueFamilyIndex].queueCount,
            XR_ERROR_GRAPHICS_DEVICE_INVALID, "the GPU has no such queue");
    require((families[binding.queueFamilyIndex].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0,
            XR_ERROR_GRAPHICS_DEVICE_INVALID, "the queue has no graphics");
}

}  // namespace

VulkanDevice::VulkanDevice(const VulkanInstance& vulkan, const XrGraphicsBindingVulkanKHR& binding)
    : VulkanDevice() {
    // The delegated constructor has completed. If the code below throws, the destructor therefore runs.
    checkQueue(vulkan, binding);
    physical_device = binding.physicalDevice;
    VkPhysicalDeviceProperties properties;
    instanceFunction<PFN_vkGetPhysicalDeviceProperties>(vulkan, "vkGetPhysicalDeviceProperties")(
        physical_device, &properties);
    api_version = std::min(vulkan.api_version, properties.apiVersion);
    const auto device_proc = instanceFunction<PFN_vkGetDeviceProcAddr>(vulkan, "vkGetDeviceProcAddr");
#define XRMOCK_LOAD(name)                                                    \
    name = reinterpret_cast<PFN_##name>(device_proc(binding.device, #name)); \
    if (name == nullptr) refuse(XR_ERROR_GRAPHICS_DEVICE_INVALID, #name " is missing");
    XRMOCK_VULKAN_FUNCTIONS(XRMOCK_LOAD)
#undef XRMOCK_LOAD
    vkGetPhysicalDeviceFormatProperties = instanceFunction<PFN_vkGetPhysicalDeviceFormatProperties>(
        vulkan, "vkGetPhysicalDeviceFormatProperties");
    vkGetPhysicalDeviceImageFormatProperties = instanceFunction<PFN_vkGetPhysicalDeviceImageFormatProperties>(
        vulkan, "vkGetPhysicalDeviceImageFormatProperties");
    instanceFunction<PFN_vkGetPhysicalDeviceMemoryProperties>(vulkan, "vkGetPhysicalDeviceMemoryProperties")(
        physical_device, &memory);
    device = binding.device;
    vkGetDeviceQueue(device, binding.queueFamilyIndex, binding.queueIndex, &queue);

    const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr,
                                            VK_COMMAND_POOL_CREATE_TRANSIENT_BIT, binding.queueFamilyIndex};
    check(vkCreateCommandPool(device, &pool_info, nullptr, &pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo commands_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr,
                                                    pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    check(vkAllocateCommandBuffers(device, &commands_info, &commands), "vkAllocateCommandBuffers");
    check(vkCreateFence(device, &fence_info, nullptr, &fence), "vkCreateFence");
}

VulkanDevice::~VulkanDevice() {
    if (device == VK_NULL_HANDLE) return;
    vkDestroyFence(device, fence, nullptr);
    vkDestroyCommandPool(device, pool, nullptr);
}

void VulkanDevice::beginCommands() {
    check(vkResetCommandPool(device, pool, 0), "vkResetCommandPool");
    const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                        VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, nullptr};
    check(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
}

void VulkanDevice::finishCommands() {
    check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands;
    check(vkResetFences(device, 1, &fence), "vkResetFences");
    check(vkQueueSubmit(queue, 1, &info, fence), "vkQueueSubmit");
    constexpr std::uint64_t kTimeoutNs = 60'000'000'000;
    check(vkWaitForFences(device, 1, &fence, VK_TRUE, kTimeoutNs), "vkWaitForFences");
}

std::uint32_t VulkanDevice::memoryType(std::uint32_t allowed, VkMemoryPropertyFlags wanted) const {
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    refuse(XR_ERROR_RUNTIME_FAILURE, "the GPU has no memory of the kind a swapchain needs");
}

bool VulkanDevice::formatSupports(VkFormat format, VkFormatFeatureFlags features) const {
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(physical_device, format, &properties);
    return (properties.optimalTilingFeatures & features) == features;
}

std::vector<VkFormat> swapchainFormats(const VulkanDevice& device) {
    constexpr VkFormat kPreferred[] = {
        VK_FORMAT_R8G8B8A8_SRGB,     VK_FORMAT_B8G8R8A8_SRGB,       VK_FORMAT_R8G8B8A8_UNORM,
        VK_FORMAT_B8G8R8A8_UNORM,    VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT,
        VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT_S8_UINT,  VK_FORMAT_D16_UNORM};
    std::vector<VkFormat> formats;
    for (const VkFormat format : kPreferred) {
        const VkFormatFeatureFlags needed =
            isDepthFormat(format)
                ? VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT
                : VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
        if (device.formatSupports(format, needed)) formats.push_back(format);
    }
    return formats;
}

bool isDepthFormat(VkFormat format) {
    return (imageAspect(format) & VK_IMAGE_ASPECT_DEPTH_BIT) != 0;
}

VkImageAspectFlags imageAspect(VkFormat format) {
    switch (format) {
        case VK_FORMAT_D32_SFLOAT:
        case VK_FORMAT_D16_UNORM:
            return VK_IMAGE_ASPECT_DEPTH_BIT;
        case VK_FORMAT_D24_UNORM_S8_UINT:
        case VK_FORMAT_D32_SFLOAT_S8_UINT:
            return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
        default:
            return VK_IMAGE_ASPECT_COLOR_BIT;
    }
}

}  // namespace xrmock
