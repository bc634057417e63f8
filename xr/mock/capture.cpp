#include "capture.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "call.h"
#include "png.h"

namespace xrmock {

namespace {

constexpr char kPrefix[] = "capture:";
constexpr std::size_t kMaxName = 128;

// Memory that the GPU fills and the CPU reads.
class Readback {
  public:
    Readback(const VulkanDevice& device, VkDeviceSize size) : device_(device), size_(size) {
        VkBufferCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
        info.size = size;
        info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        check(device.vkCreateBuffer(device.device, &info, nullptr, &buffer_), "vkCreateBuffer");
        try {
            allocate();
        } catch (...) {
            release();
            throw;
        }
    }
    ~Readback() { release(); }
    Readback(const Readback&) = delete;
    Readback& operator=(const Readback&) = delete;

    VkBuffer buffer() const { return buffer_; }

    std::vector<std::uint8_t> bytes() const {
        void* mapped = nullptr;
        check(device_.vkMapMemory(device_.device, memory_, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
        const auto* first = static_cast<const std::uint8_t*>(mapped);
        std::vector<std::uint8_t> copy(first, first + size_);
        device_.vkUnmapMemory(device_.device, memory_);
        return copy;
    }

  private:
    void allocate() {
        VkMemoryRequirements needs;
        device_.vkGetBufferMemoryRequirements(device_.device, buffer_, &needs);
        const VkMemoryAllocateInfo info{
            VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
            device_.memoryType(needs.memoryTypeBits,
                               VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT)};
        check(device_.vkAllocateMemory(device_.device, &info, nullptr, &memory_), "vkAllocateMemory");
        check(device_.vkBindBufferMemory(device_.device, buffer_, memory_, 0), "vkBindBufferMemory");
    }
    void release() {
        device_.vkDestroyBuffer(device_.device, buffer_, nullptr);
        device_.vkFreeMemory(device_.device, memory_, nullptr);
    }

    const VulkanDevice& device_;
    VkDeviceSize size_;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
};

void recordCopy(const VulkanDevice& device, VkCommandBuffer commands, const SubmittedImage& eye,
                VkBuffer buffer) {
    const SwapchainImages& images = eye.swapchain->images;
    VkImageMemoryBarrier barrier = imageBarrier(images, eye.image);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    barrier.oldLayout = images.restingLayout();
    barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    device.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                0, 0, nullptr, 0, nullptr, 1, &barrier);

    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, eye.array_index, 1};
    region.imageOffset = {eye.rect.offset.x, eye.rect.offset.y, 0};
    region.imageExtent = {static_cast<std::uint32_t>(eye.rect.extent.width),
                          static_cast<std::uint32_t>(eye.rect.extent.height), 1};
    device.vkCmdCopyImageToBuffer(commands, images.images[eye.image], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                  buffer, 1, &region);

    VkBufferMemoryBarrier to_host{};
    to_host.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER;
    to_host.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    to_host.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    to_host.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    to_host.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    to_host.buffer = buffer;
    to_host.size = VK_WHOLE_SIZE;
    device.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 0,
                                nullptr, 1, &to_host, 0, nullptr);

    barrier.srcAccessMask = 0;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    std::swap(barrier.oldLayout, barrier.newLayout);
    device.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                0, 0, nullptr, 0, nullptr, 1, &barrier);
}

// Four bytes a pixel to three; the stored values are not converted.
std::vector<std::uint8_t> toRgb(const std::vector<std::uint8_t>& pixels, VkFormat format) {
    const bool blue_first = format == VK_FORMAT_B8G8R8A8_SRGB || format == VK_FORMAT_B8G8R8A8_UNORM;
    const std::size_t red = blue_first ? 2 : 0;
    std::vector<std::uint8_t> rgb(pixels.size() / 4 * 3);
    for (std::size_t i = 0; i < pixels.size() / 4; ++i) {
        rgb[i * 3] = pixels[i * 4 + red];
        rgb[i * 3 + 1] = pixels[i * 4 + 1];
        rgb[i * 3 + 2] = pixels[i * 4 + 2 - red];
    }
    return rgb;
}

void captureEyes(Session& session, const std::string& name, const SubmittedLayer& projection) {
    const char* const suffixes[] = {"_left.png", "_right.png"};
    std::filesystem::create_directories(session.instance.capture_folder);
    for (std::size_t i = 0; i < projection.views.size(); ++i) {
        const SubmittedImage& eye = projection.views[i].image;
        const VkFormat format = eye.swapchain->images.format;
        if (isDepthFormat(format)) throw std::runtime_error("a depth image cannot be captured");
        const auto width = static_cast<std::uint32_t>(eye.rect.extent.width);
        const auto height = static_cast<std::uint32_t>(eye.rect.extent.height);
        if (width == 0 || height == 0) throw std::runtime_error("the sub-image is empty");
        const Readback readback(session.device, VkDeviceSize{width} * height * 4);
        session.device.submitAndWait(
            [&](VkCommandBuffer commands) { recordCopy(session.device, commands, eye, readback.buffer()); });
        writePng(session.instance.capture_folder + "/" + name + suffixes[i], width, height,
                 toRgb(readback.bytes(), format));
    }
    ++session.instance.statistics.captured;
}

}  // namespace

std::string captureName(const std::string& label) {
    if (!label.starts_with(kPrefix)) return {};
    const std::string name = label.substr(sizeof kPrefix - 1);
    const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || c == '.';
    });
    return plain && name.size() <= kMaxName && !name.starts_with('.') ? name : std::string();
}

void captureIfDue(Call& call, Session& session, const SubmittedFrame& frame) {
    const auto shown =
        std::find_if(frame.layers.begin(), frame.layers.end(),
                     [](const SubmittedLayer& layer) { return layer.type == LayerType::projection; });
    if (session.capture_name.empty() || shown == frame.layers.end()) return;
    try {
        captureEyes(session, session.capture_name, *shown);
    } catch (const Refused& refused) {
        warn(call, "capture " + session.capture_name + ": " + refused.reason);
    } catch (const std::exception& error) {
        warn(call, "capture " + session.capture_name + ": " + error.what());
    }
    session.capture_name.clear();
}

void writeStatistics(const Instance& instance) {
    std::error_code unwritable;  // then there is nobody to tell: the instance is going
    std::filesystem::create_directories(instance.capture_folder, unwritable);
    const Statistics& counts = instance.statistics;
    std::ofstream(instance.capture_folder + "/frames.json")
        << "{\n    \"submitted\": " << counts.submitted << ",\n    \"discarded\": " << counts.discarded
        << ",\n    \"missed\": " << counts.missed << ",\n    \"captured\": " << counts.captured
        << ",\n    \"haptic_pulses\": " << counts.haptic_pulses << "\n}\n";
}

}  // namespace xrmock
