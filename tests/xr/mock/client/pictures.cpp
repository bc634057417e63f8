#include "tests/xr/mock/client/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstring>

// The functions are in libstb. This header only declares them.
#include <stb/stb_image.h>

namespace mock_test {

Picture readPicture(const std::filesystem::path& path) {
    Picture picture;
    int channels = 0;
    stbi_uc* data = stbi_load(path.c_str(), &picture.width, &picture.height, &channels, 3);
    if (data == nullptr) return {};
    EXPECT_EQ(channels, 3);
    picture.pixels.resize(static_cast<std::size_t>(picture.width * picture.height));
    std::memcpy(picture.pixels.data(), data, picture.pixels.size() * 3);
    stbi_image_free(data);
    return picture;
}

XrCompositionLayerCylinderKHR cylinderLayer(XrSpace space, const Swapchain& swapchain, float radius_m,
                                            float angle_rad, float aspect_ratio) {
    return {XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR,
            nullptr,
            0,
            space,
            XR_EYE_VISIBILITY_BOTH,
            whole(swapchain),
            kIdentity,
            radius_m,
            angle_rad,
            aspect_ratio};
}

XrQuaternionf turned(double angle_rad, XrVector3f unit_axis) {
    const auto s = static_cast<float>(std::sin(angle_rad / 2));
    return {unit_axis.x * s, unit_axis.y * s, unit_axis.z * s, static_cast<float>(std::cos(angle_rad / 2))};
}

std::vector<Rgba> pattern(int width, int height, int cells) {
    std::vector<Rgba> texels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const bool light = (x * cells / width + y * cells / height) % 2 == 0;
            const double u = double{x + 0.5} / width, v = double{y + 0.5} / height;
            const double ring = std::hypot(u - 0.5, v - 0.5);
            texels.push_back({static_cast<std::uint8_t>(255 * u), static_cast<std::uint8_t>(light ? 220 : 60),
                              static_cast<std::uint8_t>(255 * (1 - v)),
                              static_cast<std::uint8_t>(255 * std::clamp(1.5 - 3 * ring, 0.0, 1.0))});
        }
    }
    return texels;
}

void PictureTest::TearDown() {
    if (vk_device_ != VK_NULL_HANDLE) vkDeviceWaitIdle(vk_device_);
    for (VkCommandPool pool : pools_)
        vkDestroyCommandPool(vk_device_, pool, nullptr);
    if (staging_ != VK_NULL_HANDLE) {
        vkDestroyBuffer(vk_device_, staging_, nullptr);
        vkFreeMemory(vk_device_, staging_memory_, nullptr);
    }
    MockTest::TearDown();
}

template <class Record>
void PictureTest::submitCommands(Record record) {
    VkCommandPoolCreateInfo pool_info{};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.queueFamilyIndex = vk_queue_family_;
    VkCommandPool pool = VK_NULL_HANDLE;
    ASSERT_EQ(vkCreateCommandPool(vk_device_, &pool_info, nullptr, &pool), VK_SUCCESS);
    pools_.push_back(pool);
    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = pool;
    allocate.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    ASSERT_EQ(vkAllocateCommandBuffers(vk_device_, &allocate, &commands), VK_SUCCESS);
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    vkBeginCommandBuffer(commands, &begin);
    record(commands);
    vkEndCommandBuffer(commands);
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    ASSERT_EQ(vkQueueSubmit(vk_queue_, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
}

// Changes the image's layout for a copy, and back. The runtime provides images in COLOR_ATTACHMENT_OPTIMAL
// and expects them in this layout when they are released.
void PictureTest::move(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) {
    const bool back = to == VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcAccessMask = back ? VK_ACCESS_TRANSFER_WRITE_BIT : 0;
    barrier.dstAccessMask = back ? 0 : VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT;
    vkCmdPipelineBarrier(commands, back ? VK_PIPELINE_STAGE_TRANSFER_BIT : VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                         back ? VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT : VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0,
                         nullptr, 0, nullptr, 1, &barrier);
}

void PictureTest::makeStaging(std::size_t size) {
    if (staging_ != VK_NULL_HANDLE) {
        vkDeviceWaitIdle(vk_device_);
        vkDestroyBuffer(vk_device_, staging_, nullptr);
        vkFreeMemory(vk_device_, staging_memory_, nullptr);
    }
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    ASSERT_EQ(vkCreateBuffer(vk_device_, &info, nullptr, &staging_), VK_SUCCESS);
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(vk_device_, staging_, &needs);
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(vk_physical_device_, &memory);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    constexpr VkMemoryPropertyFlags kHost =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    while ((memory.memoryTypes[allocate.memoryTypeIndex].propertyFlags & kHost) != kHost ||
           (needs.memoryTypeBits >> allocate.memoryTypeIndex & 1) == 0) {
        ++allocate.memoryTypeIndex;
    }
    ASSERT_EQ(vkAllocateMemory(vk_device_, &allocate, nullptr, &staging_memory_), VK_SUCCESS);
    ASSERT_EQ(vkBindBufferMemory(vk_device_, staging_, staging_memory_, 0), VK_SUCCESS);
}

Swapchain PictureTest::picture(std::uint32_t width, std::uint32_t height, const std::vector<Rgba>& texels,
                               VkFormat format) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.usageFlags |= XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT;
    info.width = width;
    info.height = height;
    info.format = format;
    info.arraySize = static_cast<std::uint32_t>(texels.size() / (width * height));
    const Swapchain swapchain = createSwapchain(info);
    draw(swapchain, texels);
    return swapchain;
}

void PictureTest::draw(const Swapchain& swapchain, const std::vector<Rgba>& texels) {
    const VkImage image = swapchain.images[acquireAndWait(swapchain.handle)];
    const std::size_t size = texels.size() * sizeof(Rgba);
    makeStaging(size);
    void* mapped = nullptr;
    ASSERT_EQ(vkMapMemory(vk_device_, staging_memory_, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
    std::memcpy(mapped, texels.data(), size);
    vkUnmapMemory(vk_device_, staging_memory_);
    submitCommands([&](VkCommandBuffer commands) {
        move(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkBufferImageCopy region{};
        const std::size_t layers = texels.size() / (swapchain.width * swapchain.height);
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, static_cast<std::uint32_t>(layers)};
        region.imageExtent = {swapchain.width, swapchain.height, 1};
        vkCmdCopyBufferToImage(commands, staging_, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
        move(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    });
    ASSERT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_SUCCESS);
}

std::vector<Rgba> PictureTest::readTexels(const Swapchain& swapchain, VkImage image, std::uint32_t layers) {
    std::vector<Rgba> texels(std::size_t{swapchain.width} * swapchain.height * layers);
    makeStaging(texels.size() * sizeof(Rgba));
    submitCommands([&](VkCommandBuffer commands) {
        move(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, layers};
        region.imageExtent = {swapchain.width, swapchain.height, 1};
        vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging_, 1, &region);
        move(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    });
    vkDeviceWaitIdle(vk_device_);
    void* mapped = nullptr;
    EXPECT_EQ(vkMapMemory(vk_device_, staging_memory_, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
    std::memcpy(texels.data(), mapped, texels.size() * sizeof(Rgba));
    vkUnmapMemory(vk_device_, staging_memory_);
    return texels;
}

void PictureTest::label(const char* name) {
    const XrDebugUtilsLabelEXT info{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name};
    EXPECT_EQ(load<PFN_xrSessionInsertDebugUtilsLabelEXT>(instance_, "xrSessionInsertDebugUtilsLabelEXT")(
                  session_, &info),
              XR_SUCCESS);
}

}  // namespace mock_test
