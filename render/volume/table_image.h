// A small 3D texture of half floats that can be rewritten every frame. Its staging buffer is permanent, and
// the frame's own commands copy it.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "base/geometry.h"
#include "render/gpu/memory.h"
#include "render/volume/workers.h"

namespace stylet::render {

// Half floats: every device can filter them, and a value of 15 mm is accurate to 0.01 mm.
inline constexpr vk::Format kTableFormat = vk::Format::eR16G16B16A16Sfloat;

class TableImage {
  public:
    TableImage(const Gpu&, const Index3& dims);

    // `table`: x-fastest, one entry per texel. Must not be called while a frame is in flight.
    void write(const std::vector<glm::vec4>& table, Workers&);
    // Must come first in a frame. Does nothing if nothing was written.
    void recordUpload(const vk::raii::CommandBuffer&);

    const GpuImage& image() const { return image_; }  // SHADER_READ_ONLY after its first upload
    Index3 dims() const {
        return {int(image_.extent.width), int(image_.extent.height), int(image_.extent.depth)};
    }

  private:
    GpuImage image_;
    Buffer staging_;
    bool stale_ = true;
};

// Converts to RGBA16F, rounded to nearest. Uses F16C where the processor has it.
void packHalves(const glm::vec4* from, std::size_t count, std::uint64_t* to);

}  // namespace stylet::render
