#include "compositor/gpu_objects.h"

#include "compositor/refused.h"

namespace xrmock {

namespace {

Memory allocate(const VulkanDevice& device, const VkMemoryRequirements& needs, VkMemoryPropertyFlags kind) {
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
                                    device.memoryType(needs.memoryTypeBits, kind)};
    return {device, device.vkAllocateMemory, info, "vkAllocateMemory"};
}

}  // namespace

DeviceImage::DeviceImage(const VulkanDevice& device, const VkImageCreateInfo& info)
    : image(device, device.vkCreateImage, info, "vkCreateImage") {
    VkMemoryRequirements needs;
    device.vkGetImageMemoryRequirements(device.device, image, &needs);
    memory = allocate(device, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(device.vkBindImageMemory(device.device, image, memory, 0), "vkBindImageMemory");
}

DeviceImage makeTarget(const VulkanDevice& device, VkFormat format, VkExtent2D size, VkImageUsageFlags usage,
                       std::uint32_t layers) {
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {size.width, size.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = usage;
    return {device, info};
}

ReadbackBuffer::ReadbackBuffer(const VulkanDevice& device, VkDeviceSize byte_count) : size(byte_count) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    buffer = Buffer(device, device.vkCreateBuffer, info, "vkCreateBuffer");
    VkMemoryRequirements needs;
    device.vkGetBufferMemoryRequirements(device.device, buffer, &needs);
    memory =
        allocate(device, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(device.vkBindBufferMemory(device.device, buffer, memory, 0), "vkBindBufferMemory");
}

std::vector<std::uint8_t> ReadbackBuffer::bytes(const VulkanDevice& device) const {
    void* mapped = nullptr;
    check(device.vkMapMemory(device.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    const auto* first = static_cast<const std::uint8_t*>(mapped);
    std::vector<std::uint8_t> copy(first, first + size);
    device.vkUnmapMemory(device.device, memory);
    return copy;
}

ImageView arrayView(const VulkanDevice& device, VkImage image, VkFormat format, VkImageUsageFlags usage) {
    // Without usage_info the view would inherit all usages of the image. The image's format may
    // not support all of them (VulkanDevice::hasExtendedUsage).
    const VkImageViewUsageCreateInfo usage_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO, nullptr,
                                                usage};
    VkImageViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    if (device.hasExtendedUsage()) info.pNext = &usage_info;
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    info.format = format;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
    return {device, device.vkCreateImageView, info, "vkCreateImageView"};
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
    if ((info.usageFlags & XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT) != 0)
        image.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
    if ((info.usageFlags & XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT) != 0 && device.hasExtendedUsage() &&
        !device.formatSupports(image.format, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT)) {
        // The image's own format, typically sRGB, does not support storage. A view of the image in a linear
        // format may support it. The two flags allow such a view.
        image.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT;
    }
    return image;
}

}  // namespace

SwapchainImages::SwapchainImages(const VulkanDevice& device, const XrSwapchainCreateInfo& info,
                                 std::uint32_t count)
    : format(static_cast<VkFormat>(info.format)),
      width(info.width),
      height(info.height),
      layers(info.arraySize),
      samples(info.sampleCount) {
    const VkImageCreateInfo image_info = imageInfo(device, info);
    VkImageFormatProperties limits;
    const VkResult supported = device.vkGetPhysicalDeviceImageFormatProperties(
        device.physical_device, format, image_info.imageType, image_info.tiling, image_info.usage,
        image_info.flags, &limits);
    require(supported == VK_SUCCESS && info.width <= limits.maxExtent.width &&
                info.height <= limits.maxExtent.height && info.mipCount <= limits.maxMipLevels &&
                info.arraySize <= limits.maxArrayLayers && (limits.sampleCounts & info.sampleCount) != 0,
            XR_ERROR_FEATURE_UNSUPPORTED, "the GPU has no images of this size, format and usage");
    for (std::uint32_t i = 0; i < count; ++i)
        images.emplace_back(device, image_info);
    in_resting_layout.assign(count, false);
}

VkImageLayout SwapchainImages::restingLayout() const {
    return isDepthFormat(format) ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                 : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
}

VkImageMemoryBarrier imageBarrier(VkImage image, VkImageAspectFlags aspect) {
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    return barrier;
}

void transitionToRestingLayout(VulkanDevice& device, SwapchainImages& swapchain) {
    std::vector<VkImageMemoryBarrier> barriers;
    for (std::uint32_t i = 0; i < swapchain.images.size(); ++i) {
        if (swapchain.in_resting_layout[i]) continue;
        VkImageMemoryBarrier barrier = imageBarrier(swapchain.images[i].image, imageAspect(swapchain.format));
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
    swapchain.in_resting_layout.assign(swapchain.images.size(), true);
}

}  // namespace xrmock
