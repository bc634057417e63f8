// Buffers and images that own their memory, and work that is submitted and waited for.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "render/gpu.h"

namespace stylet::render {

// Host-visible and mapped for its whole life. The renderer waits for each frame, so nothing is written while
// read.
struct Buffer {
    vk::raii::Buffer handle = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    vk::DeviceSize size = 0;
    void* mapped = nullptr;

    Buffer() = default;
    Buffer(const Gpu&, vk::DeviceSize size, vk::BufferUsageFlags);
    void write(const void* data, std::size_t bytes, std::size_t at = 0);
};

struct GpuImage {
    vk::raii::Image handle = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    vk::raii::ImageView view = nullptr;
    vk::Extent3D extent{};
    std::uint32_t layers = 1;

    GpuImage() = default;
    // 3D when extent.depth > 1, otherwise a 2D array of `layers`.
    GpuImage(const Gpu&, vk::Format, vk::Extent3D extent, std::uint32_t layers, vk::ImageUsageFlags);
};

// Records, submits and waits. Throws vk::SystemError.
void submitAndWait(const Gpu&, const std::function<void(const vk::raii::CommandBuffer&)>& record);

struct ImageState {
    vk::ImageLayout layout;
    vk::PipelineStageFlags2 stage;
    vk::AccessFlags2 access;
};
void transition(const vk::raii::CommandBuffer&, vk::Image, vk::ImageAspectFlags, ImageState from,
                ImageState to);

// Fills a 3D image slab by slab through a small staging buffer, so that neither a whole copy in host memory
// nor a buffer above maxStorageBufferRange is needed. `fill(z0, z1, out)` writes whole planes; the image ends
// in SHADER_READ_ONLY_OPTIMAL.
void uploadPlanes(const Gpu&, const GpuImage&, std::size_t bytes_per_texel,
                  const std::function<void(int z0, int z1, std::byte* out)>& fill);

// Layer `layer` of a colour image in `layout`, tightly packed, four bytes a texel.
std::vector<std::uint8_t> readLayer(const Gpu&, vk::Image, vk::Extent2D, std::uint32_t layer,
                                    ImageState state);

}  // namespace stylet::render
