#include "compositor/gpu_objects.h"

namespace xrmock {

namespace {

Memory allocate(const VulkanDevice& device, const VkMemoryRequirements& needs, VkMemoryPropertyFlags kind) {
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
                                    device.memoryType(needs.memoryTypeBits, kind)};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(device.vkAllocateMemory(device.device, &info, nullptr, &memory), "vkAllocateMemory");
    return {device, memory};
}

}  // namespace

TargetImage::TargetImage(const VulkanDevice& device, VkFormat format, VkExtent2D size,
                         VkImageUsageFlags usage, std::uint32_t layers) {
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
    VkImage created = VK_NULL_HANDLE;
    check(device.vkCreateImage(device.device, &info, nullptr, &created), "vkCreateImage");
    image = Image(device, created);
    VkMemoryRequirements needs;
    device.vkGetImageMemoryRequirements(device.device, image, &needs);
    memory = allocate(device, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(device.vkBindImageMemory(device.device, image, memory, 0), "vkBindImageMemory");
}

ReadbackBuffer::ReadbackBuffer(const VulkanDevice& device, VkDeviceSize byte_count) : size(byte_count) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer created = VK_NULL_HANDLE;
    check(device.vkCreateBuffer(device.device, &info, nullptr, &created), "vkCreateBuffer");
    buffer = Buffer(device, created);
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
    // The image may have usages that its own format does not support (VulkanDevice::hasExtendedUsage).
    const VkImageViewUsageCreateInfo usage_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO, nullptr,
                                                usage};
    VkImageViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    if (device.hasExtendedUsage()) info.pNext = &usage_info;
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    info.format = format;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
    VkImageView view = VK_NULL_HANDLE;
    check(device.vkCreateImageView(device.device, &info, nullptr, &view), "vkCreateImageView");
    return {device, view};
}

}  // namespace xrmock
