// A small 3D texture of half floats that is written anew while frames go by: staging that stays, copied by
// the frame's own commands.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "patient/geometry.h"
#include "render/memory.h"
#include "render/volume/workers.h"

namespace stylet::render {

// Half floats: every device filters them, and 15 mm are held to 0.01 mm.
inline constexpr vk::Format kTableFormat = vk::Format::eR16G16B16A16Sfloat;

class TableImage {
  public:
    TableImage(const Gpu&, const patient::Index3& dims);

    // x-fastest, as many as there are texels. Not while a frame is in flight.
    void write(const std::vector<glm::vec4>& table, Workers&);
    // First in a frame; nothing where nothing was written.
    void recordUpload(const vk::raii::CommandBuffer&);

    const GpuImage& image() const { return image_; }  // SHADER_READ_ONLY after its first upload
    patient::Index3 dims() const {
        return {int(image_.extent.width), int(image_.extent.height), int(image_.extent.depth)};
    }

  private:
    GpuImage image_;
    Buffer staging_;
    bool stale_ = true;
};

// RGBA16F, rounded to nearest; F16C where the processor has it.
void packHalves(const glm::vec4* from, std::size_t count, std::uint64_t* to);

}  // namespace stylet::render
