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
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY) {
        refuse(XR_ERROR_OUT_OF_MEMORY, std::string(function) + " is out of memory");
    }
    if (result != VK_SUCCESS) {
        refuse(XR_ERROR_RUNTIME_FAILURE, std::string(function) + " returned " + std::to_string(result));
    }
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

PFN_vkGetInstanceProcAddr loaderInUse() {
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

VulkanDevice::VulkanDevice(VulkanDevice&& other) noexcept
    :
#define XRMOCK_COPY(name) name(other.name),
      XRMOCK_VULKAN_FUNCTIONS(XRMOCK_COPY)
#undef XRMOCK_COPY
          vkGetPhysicalDeviceFormatProperties(other.vkGetPhysicalDeviceFormatProperties),
      vkGetPhysicalDeviceImageFormatProperties(other.vkGetPhysicalDeviceImageFormatProperties),
      physical_device(other.physical_device),
      device(std::exchange(other.device, VK_NULL_HANDLE)),
      queue(other.queue),
      pool(other.pool),
      commands(other.commands),
      fence(other.fence),
      memory(other.memory),
      api_version(other.api_version) {
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
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        if ((allowed >> i & 1) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    }
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
    return (aspectOf(format) & VK_IMAGE_ASPECT_DEPTH_BIT) != 0;
}

VkImageAspectFlags aspectOf(VkFormat format) {
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

namespace {

VkImageCreateInfo imageInfo(const VulkanDevice& device, const XrSwapchainCreateInfo& info) {
    VkImageCreateInfo image{};
    image.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    image.imageType = VK_IMAGE_TYPE_2D;
    image.format = static_cast<VkFormat>(info.format);
    image.extent = {info.width, info.height, 1};
    image.mipLevels = info.mipCount;
    image.arrayLayers = info.arraySize;
    image.samples = static_cast<VkSampleCountFlagBits>(info.sampleCount);
    image.tiling = VK_IMAGE_TILING_OPTIMAL;
    image.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    // Add the usages that the compositor needs (sampling and copying). Between frames an image rests in an
    // attachment layout (see restingLayout()), which requires the matching attachment usage.
    image.usage = isDepthFormat(image.format)
                      ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                      : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    image.usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    const auto use = [&](XrSwapchainUsageFlags asked, VkImageUsageFlags usage) {
        if ((info.usageFlags & asked) != 0) image.usage |= usage;
    };
    use(XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT, VK_IMAGE_USAGE_STORAGE_BIT);
    use(XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    use(XR_SWAPCHAIN_USAGE_SAMPLED_BIT, VK_IMAGE_USAGE_SAMPLED_BIT);
    if ((info.usageFlags & XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT) != 0) {
        image.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
    }
    if ((info.usageFlags & XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT) != 0 && device.hasExtendedUsage() &&
        !device.formatSupports(image.format, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT)) {
        // The image's own format cannot be used for storage images; sRGB formats are typical. A view of the
        // image in a linear format may support them. The two flags allow such a view.
        image.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT;
    }
    return image;
}

}  // namespace

SwapchainImages::SwapchainImages(const VulkanDevice& owner, const XrSwapchainCreateInfo& info)
    : device(&owner),
      format(static_cast<VkFormat>(info.format)),
      width(info.width),
      height(info.height),
      layers(info.arraySize),
      mips(info.mipCount),
      samples(info.sampleCount) {}

SwapchainImages::SwapchainImages(const VulkanDevice& owner, const XrSwapchainCreateInfo& info,
                                 std::uint32_t count)
    : SwapchainImages(owner, info) {
    // The delegated constructor has completed. If the code below throws, the destructor therefore runs.
    const VkImageCreateInfo image_info = imageInfo(owner, info);
    VkImageFormatProperties limits;
    const VkResult supported = device->vkGetPhysicalDeviceImageFormatProperties(
        device->physical_device, format, image_info.imageType, image_info.tiling, image_info.usage,
        image_info.flags, &limits);
    require(supported == VK_SUCCESS && info.width <= limits.maxExtent.width &&
                info.height <= limits.maxExtent.height && info.mipCount <= limits.maxMipLevels &&
                info.arraySize <= limits.maxArrayLayers && (limits.sampleCounts & info.sampleCount) != 0,
            XR_ERROR_FEATURE_UNSUPPORTED, "the GPU has no images of this size, format and usage");
    images.reserve(count);
    memories.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        VkImage image = VK_NULL_HANDLE;
        check(device->vkCreateImage(device->device, &image_info, nullptr, &image), "vkCreateImage");
        images.push_back(image);
        VkMemoryRequirements needs;
        device->vkGetImageMemoryRequirements(device->device, image, &needs);
        const VkMemoryAllocateInfo memory_info{
            VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
            device->memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)};
        VkDeviceMemory memory = VK_NULL_HANDLE;
        check(device->vkAllocateMemory(device->device, &memory_info, nullptr, &memory), "vkAllocateMemory");
        memories.push_back(memory);
        check(device->vkBindImageMemory(device->device, image, memory, 0), "vkBindImageMemory");
    }
    at_rest.assign(count, false);
}

SwapchainImages::SwapchainImages(SwapchainImages&& other) noexcept
    : device(other.device),
      format(other.format),
      width(other.width),
      height(other.height),
      layers(other.layers),
      mips(other.mips),
      samples(other.samples),
      images(std::exchange(other.images, {})),
      memories(std::exchange(other.memories, {})),
      at_rest(std::move(other.at_rest)) {}

SwapchainImages::~SwapchainImages() {
    for (VkImage image : images)
        device->vkDestroyImage(device->device, image, nullptr);
    for (VkDeviceMemory memory : memories)
        device->vkFreeMemory(device->device, memory, nullptr);
}

VkImageLayout SwapchainImages::restingLayout() const {
    return isDepthFormat(format) ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                 : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
}

VkImageMemoryBarrier imageBarrier(const SwapchainImages& swapchain, std::uint32_t index) {
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = swapchain.images[index];
    barrier.subresourceRange = {aspectOf(swapchain.format), 0, VK_REMAINING_MIP_LEVELS, 0,
                                VK_REMAINING_ARRAY_LAYERS};
    return barrier;
}

void bringToRest(VulkanDevice& device, SwapchainImages& swapchain) {
    std::vector<VkImageMemoryBarrier> barriers;
    for (std::uint32_t i = 0; i < swapchain.images.size(); ++i) {
        if (swapchain.at_rest[i]) continue;
        VkImageMemoryBarrier barrier = imageBarrier(swapchain, i);
        barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        barrier.newLayout = swapchain.restingLayout();
        barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
        barriers.push_back(barrier);
    }
    if (barriers.empty()) return;
    device.submitAndWait([&](VkCommandBuffer commands) {
        device.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                                    VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr,
                                    static_cast<std::uint32_t>(barriers.size()), barriers.data());
    });
    swapchain.at_rest.assign(swapchain.images.size(), true);
}

}  // namespace xrmock
