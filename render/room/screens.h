// The pictures on the room's screens: a small image with one layer per screen. A layer is uploaded when its
// picture changes.
#pragma once

#include "render/gpu/memory.h"
#include "render/room/room_shared.h"
#include "render/scene/scene.h"

namespace stylet::render {

class Screens {
  public:
    explicit Screens(const Gpu&);

    // Copies changed pictures to the staging buffer, and sets in the uniforms which share of a layer each
    // picture fills. A picture larger than kMaxScreenPixels is a programming error.
    void update(const RenderScene&, gpu::RoomUniforms&);
    void record(const vk::raii::CommandBuffer&) const;

    const GpuImage& image() const { return image_; }

  private:
    struct Layer {
        std::uint64_t revision = 0;
        int width = 0, height = 0;
        bool changed = false;
    };
    GpuImage image_;
    Buffer staging_;
    std::array<Layer, gpu::kScreens> layers_;
};

}  // namespace stylet::render
