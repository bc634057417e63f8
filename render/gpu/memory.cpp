#include "render/gpu/memory.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include <fmt/core.h>

#include "render/gpu/image_states.h"

namespace stylet::render {
namespace {

constexpr std::size_t kStagingBytes = 48u << 20;

using MemoryFlags = vk::MemoryPropertyFlagBits;

constexpr vk::MemoryPropertyFlags kMapped = MemoryFlags::eHostVisible | MemoryFlags::eHostCoherent;

// Allocates from the first memory type with the wanted and preferred flags, else from the first with the
// wanted ones.
vk::raii::DeviceMemory allocate(const Gpu& gpu, const vk::MemoryRequirements& needs,
                                vk::MemoryPropertyFlags wanted, vk::MemoryPropertyFlags preferred = {}) {
    const auto properties = gpu.physicalDevice().getMemoryProperties();
    for (const vk::MemoryPropertyFlags flags : {wanted | preferred, wanted})
        for (std::uint32_t i = 0; i < properties.memoryTypeCount; ++i) {
            const bool allowed = needs.memoryTypeBits & (1u << i);
            if (allowed && (properties.memoryTypes[i].propertyFlags & flags) == flags)
                return gpu.device().allocateMemory({.allocationSize = needs.size, .memoryTypeIndex = i});
        }
    throw GpuError("vkGetPhysicalDeviceMemoryProperties: no memory of this graphics device is " +
                   vk::to_string(wanted));
}

Buffer mappedBuffer(const Gpu& gpu, vk::DeviceSize bytes, vk::BufferUsageFlags usage,
                    vk::MemoryPropertyFlags preferred) {
    Buffer buffer;
    buffer.size = bytes;
    buffer.handle = gpu.device().createBuffer({.size = bytes, .usage = usage});
    buffer.memory = allocate(gpu, buffer.handle.getMemoryRequirements(), kMapped, preferred);
    buffer.handle.bindMemory(*buffer.memory, 0);
    buffer.mapped = buffer.memory.mapMemory(0, VK_WHOLE_SIZE);
    return buffer;
}

}  // namespace

Buffer::Buffer(const Gpu& gpu, vk::DeviceSize bytes, vk::BufferUsageFlags usage)
    : Buffer(mappedBuffer(gpu, bytes, usage, {})) {}

void Buffer::write(const void* data, std::size_t bytes, std::size_t at) {
    assert(at + bytes <= size);
    std::memcpy(static_cast<std::byte*>(mapped) + at, data, bytes);
}

Buffer makeReadBuffer(const Gpu& gpu, vk::DeviceSize bytes, vk::BufferUsageFlags usage) {
    return mappedBuffer(gpu, bytes, usage, MemoryFlags::eHostCached);
}

Buffer makeDeviceBuffer(const Gpu& gpu, vk::DeviceSize bytes, vk::BufferUsageFlags usage) {
    Buffer buffer;
    buffer.size = bytes;
    buffer.handle = gpu.device().createBuffer({.size = bytes, .usage = usage});
    buffer.memory = allocate(gpu, buffer.handle.getMemoryRequirements(), MemoryFlags::eDeviceLocal);
    buffer.handle.bindMemory(*buffer.memory, 0);
    return buffer;
}

GpuImage::GpuImage(const Gpu& gpu, vk::Format format, vk::Extent3D size, std::uint32_t layer_count,
                   vk::ImageUsageFlags usage)
    : extent(size), layers(layer_count) {
    const bool volume = size.depth > 1;
    handle = gpu.device().createImage({.imageType = volume ? vk::ImageType::e3D : vk::ImageType::e2D,
                                       .format = format,
                                       .extent = size,
                                       .mipLevels = 1,
                                       .arrayLayers = layer_count,
                                       .samples = vk::SampleCountFlagBits::e1,
                                       .tiling = vk::ImageTiling::eOptimal,
                                       .usage = usage});
    memory = allocate(gpu, handle.getMemoryRequirements(), MemoryFlags::eDeviceLocal);
    handle.bindMemory(*memory, 0);
    const bool depth = format == vk::Format::eD32Sfloat;
    view = gpu.device().createImageView(
        {.image = *handle,
         .viewType = volume ? vk::ImageViewType::e3D : vk::ImageViewType::e2DArray,
         .format = format,
         .subresourceRange = {depth ? vk::ImageAspectFlagBits::eDepth : vk::ImageAspectFlagBits::eColor, 0, 1,
                              0, layer_count}});
}

GpuImage makeVolumeImage(const Gpu& gpu, vk::Format format, const glm::ivec3& texels) {
    const auto limit = gpu.physicalDevice().getProperties().limits.maxImageDimension3D;
    if (std::uint32_t(std::max({texels.x, texels.y, texels.z})) > limit)
        throw GpuError(
            fmt::format("vkCreateImage: the volume has {} x {} x {} voxels, and this graphics device "
                        "holds at most {} along an edge. Use a patient with fewer voxels.",
                        texels.x, texels.y, texels.z, limit));
    return GpuImage(gpu, format, {std::uint32_t(texels.x), std::uint32_t(texels.y), std::uint32_t(texels.z)},
                    1, vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferDst);
}

GpuImage makeFilledVolume(const Gpu& gpu, vk::Format format, const glm::ivec3& texels,
                          std::size_t bytes_per_texel, const void* contents) {
    GpuImage image = makeVolumeImage(gpu, format, texels);
    const std::size_t plane = bytes_per_texel * std::size_t(texels.x) * std::size_t(texels.y);
    uploadPlanes(gpu, image, bytes_per_texel, [&](int z0, int z1, std::byte* out) {
        std::memcpy(out, static_cast<const std::byte*>(contents) + plane * std::size_t(z0),
                    plane * std::size_t(z1 - z0));
    });
    return image;
}

vk::raii::Sampler makeSampler(const Gpu& gpu, vk::Filter filter, vk::SamplerAddressMode beyond) {
    return gpu.device().createSampler({.magFilter = filter,
                                       .minFilter = filter,
                                       .addressModeU = beyond,
                                       .addressModeV = beyond,
                                       .addressModeW = beyond,
                                       .borderColor = vk::BorderColor::eFloatTransparentBlack});
}

vk::raii::CommandBuffer makeCommandBuffer(const Gpu& gpu, const vk::raii::CommandPool& pool) {
    auto buffers = gpu.device().allocateCommandBuffers(
        {.commandPool = *pool, .level = vk::CommandBufferLevel::ePrimary, .commandBufferCount = 1});
    return std::move(buffers.front());
}

Commands::Commands(const Gpu& gpu)
    : gpu_(&gpu),
      pool_(gpu.device(), vk::CommandPoolCreateInfo{.flags = vk::CommandPoolCreateFlagBits::eTransient,
                                                    .queueFamilyIndex = gpu.queueFamily()}),
      buffer_(makeCommandBuffer(gpu, pool_)),
      done_(gpu.device(), vk::FenceCreateInfo{}) {}

void Commands::begin() {
    pool_.reset();
    buffer_.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
}

void Commands::endAndWait() {
    buffer_.end();
    const vk::CommandBufferSubmitInfo info{.commandBuffer = *buffer_};
    gpu_->queue().submit2(vk::SubmitInfo2{.commandBufferInfoCount = 1, .pCommandBufferInfos = &info}, *done_);
    if (gpu_->device().waitForFences(*done_, true, UINT64_MAX) != vk::Result::eSuccess)
        throw GpuError("vkWaitForFences: the frame did not finish");
    gpu_->device().resetFences(*done_);
}

void submitAndWait(const Gpu& gpu, const std::function<void(const vk::raii::CommandBuffer&)>& record) {
    Commands(gpu).submitAndWait(record);
}

void transition(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageAspectFlags aspect,
                ImageState from, ImageState to) {
    const vk::ImageMemoryBarrier2 barrier{
        .srcStageMask = from.stage,
        .srcAccessMask = from.access,
        .dstStageMask = to.stage,
        .dstAccessMask = to.access,
        .oldLayout = from.layout,
        .newLayout = to.layout,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image,
        .subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
    commands.pipelineBarrier2({.imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier});
}

void memoryBarrier(const vk::raii::CommandBuffer& commands, MemoryUse from, MemoryUse to) {
    const vk::MemoryBarrier2 barrier{.srcStageMask = from.stage,
                                     .srcAccessMask = from.access,
                                     .dstStageMask = to.stage,
                                     .dstAccessMask = to.access};
    commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &barrier});
}

vk::BufferImageCopy imagePart(vk::Extent3D extent, std::uint32_t layers, vk::ImageAspectFlags aspect) {
    return {.imageSubresource = {aspect, 0, 0, layers}, .imageExtent = extent};
}

void recordUpload(const vk::raii::CommandBuffer& commands, const Buffer& buffer, vk::Image image,
                  const vk::BufferImageCopy& part, ImageState from, ImageState to) {
    transition(commands, image, kColour, from, kCopyWritten);
    commands.copyBufferToImage(*buffer.handle, image, kCopyWritten.layout, part);
    transition(commands, image, kColour, kCopyWritten, to);
}

void uploadPlanes(const Gpu& gpu, const GpuImage& image, std::size_t bytes_per_texel,
                  const std::function<void(int, int, std::byte*)>& fill) {
    const std::size_t plane = bytes_per_texel * image.extent.width * image.extent.height;
    const int depth = int(image.extent.depth);
    const int planes_per_slab = int(std::clamp<std::size_t>(kStagingBytes / plane, 1, std::size_t(depth)));
    Buffer staging(gpu, plane * std::size_t(planes_per_slab), vk::BufferUsageFlagBits::eTransferSrc);
    for (int z0 = 0; z0 < depth; z0 += planes_per_slab) {
        const int z1 = std::min(depth, z0 + planes_per_slab);
        fill(z0, z1, static_cast<std::byte*>(staging.mapped));
        submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
            if (z0 == 0) transition(commands, *image.handle, kColour, kUnused, kCopyWritten);
            auto part = imagePart({image.extent.width, image.extent.height, std::uint32_t(z1 - z0)});
            part.imageOffset.z = z0;
            commands.copyBufferToImage(*staging.handle, *image.handle, kCopyWritten.layout, part);
            if (z1 == depth) transition(commands, *image.handle, kColour, kCopyWritten, kShaderRead);
        });
    }
}

std::vector<std::uint8_t> readLayer(const Gpu& gpu, vk::Image image, vk::ImageAspectFlags aspect,
                                    vk::Extent2D extent, std::uint32_t layer, ImageState state) {
    const std::size_t bytes = std::size_t(extent.width) * extent.height * 4;
    const Buffer staging = makeReadBuffer(gpu, bytes, vk::BufferUsageFlagBits::eTransferDst);
    submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
        transition(commands, image, aspect, state, kCopyRead);
        auto part = imagePart({extent.width, extent.height, 1}, 1, aspect);
        part.imageSubresource.baseArrayLayer = layer;
        commands.copyImageToBuffer(image, kCopyRead.layout, *staging.handle, part);
        transition(commands, image, aspect, kCopyRead, state);
        memoryBarrier(commands, kCopyWrites, kHostReads);
    });
    std::vector<std::uint8_t> pixels(bytes);
    std::memcpy(pixels.data(), staging.mapped, bytes);
    return pixels;
}

}  // namespace stylet::render
