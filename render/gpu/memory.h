// Buffers and images that own their memory, and commands that are submitted and waited for.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "render/gpu/gpu.h"

namespace stylet::render {

// Host-visible and mapped for its whole life, except for makeDeviceBuffer(). The renderer waits for each
// frame, so the host never writes while the GPU reads.
struct Buffer {
    vk::raii::Buffer handle = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    vk::DeviceSize size = 0;
    void* mapped = nullptr;

    Buffer() = default;
    Buffer(const Gpu&, vk::DeviceSize size, vk::BufferUsageFlags);
    void write(const void* data, std::size_t bytes, std::size_t at = 0);
};

// Uses memory that the CPU reads quickly (host-cached), where the device has it.
Buffer makeReadBuffer(const Gpu&, vk::DeviceSize size, vk::BufferUsageFlags);
// Creates a buffer with these contents.
template <typename T>
Buffer makeFilledBuffer(const Gpu& gpu, const std::vector<T>& contents, vk::BufferUsageFlags usage) {
    Buffer buffer(gpu, contents.size() * sizeof(T), usage);
    buffer.write(contents.data(), contents.size() * sizeof(T));
    return buffer;
}
// Device-local and not mapped: only the GPU reads and writes it.
Buffer makeDeviceBuffer(const Gpu&, vk::DeviceSize size, vk::BufferUsageFlags);

struct GpuImage {
    vk::raii::Image handle = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    vk::raii::ImageView view = nullptr;
    vk::Extent3D extent{};
    std::uint32_t layers = 1;

    GpuImage() = default;
    // 3D when extent.depth > 1, otherwise a 2D array of `layers`.
    GpuImage(const Gpu&, vk::Format, vk::Extent3D extent, std::uint32_t layers, vk::ImageUsageFlags);
    bool hasSize(vk::Extent2D e) const { return extent.width == e.width && extent.height == e.height; }
};

// Creates a 3D image for upload and sampling. Throws GpuError if the device supports no image of this size.
GpuImage makeVolumeImage(const Gpu&, vk::Format, const glm::ivec3& texels);

// Creates a 3D image with these texels (x-fastest), in SHADER_READ_ONLY_OPTIMAL.
GpuImage makeFilledVolume(const Gpu&, vk::Format, const glm::ivec3& texels, std::size_t bytes_per_texel,
                          const void* contents);

vk::raii::Sampler makeSampler(const Gpu&, vk::Filter, vk::SamplerAddressMode beyond);

vk::raii::CommandBuffer makeCommandBuffer(const Gpu&, const vk::raii::CommandPool&);

// A reusable command buffer. Submitting a frame allocates nothing.
class Commands {
  public:
    explicit Commands(const Gpu&);
    // Records, submits and waits. Throws vk::SystemError.
    template <typename Record>
    void submitAndWait(const Record& record) {
        begin();
        record(buffer_);
        endAndWait();
    }

  private:
    void begin();
    void endAndWait();
    const Gpu* gpu_;
    vk::raii::CommandPool pool_;
    vk::raii::CommandBuffer buffer_ = nullptr;
    vk::raii::Fence done_;
};

// Does the same once, with a temporary command buffer.
void submitAndWait(const Gpu&, const std::function<void(const vk::raii::CommandBuffer&)>& record);

struct ImageState {
    vk::ImageLayout layout;
    vk::PipelineStageFlags2 stage;
    vk::AccessFlags2 access;
};
void transition(const vk::raii::CommandBuffer&, vk::Image, vk::ImageAspectFlags, ImageState from,
                ImageState to);

// How commands before or after a barrier use memory.
struct MemoryUse {
    vk::PipelineStageFlags2 stage;
    vk::AccessFlags2 access;
};
void memoryBarrier(const vk::raii::CommandBuffer&, MemoryUse from, MemoryUse to);

// Describes a copy of tightly packed texels between a buffer and a part of an image; by default all of layer
// 0.
vk::BufferImageCopy imagePart(vk::Extent3D extent, std::uint32_t layers = 1,
                              vk::ImageAspectFlags = vk::ImageAspectFlagBits::eColor);
// Records the copy of a buffer to a part of a colour image, with the transitions before and after.
void recordUpload(const vk::raii::CommandBuffer&, const Buffer&, vk::Image, const vk::BufferImageCopy&,
                  ImageState from, ImageState to);

// Fills a 3D image slab by slab through a small staging buffer, so that neither a whole copy in host memory
// nor a buffer above maxStorageBufferRange is needed. `fill(z0, z1, out)` writes whole planes; the image ends
// in SHADER_READ_ONLY_OPTIMAL.
void uploadPlanes(const Gpu&, const GpuImage&, std::size_t bytes_per_texel,
                  const std::function<void(int z0, int z1, std::byte* out)>& fill);

// Reads layer `layer` of an image with four bytes per texel, tightly packed. The image is in `state` before
// and after.
std::vector<std::uint8_t> readLayer(const Gpu&, vk::Image, vk::ImageAspectFlags, vk::Extent2D,
                                    std::uint32_t layer, ImageState state);

}  // namespace stylet::render
