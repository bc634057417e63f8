// Shows pictures from host memory on a window's surface, placed and scaled but not blended. The caller owns
// the window and handles its events.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "render/gpu/gpu.h"

namespace stylet::render {

struct PlacedPicture {
    std::size_t picture = 0;  // id passed to setPicture()
    std::int32_t x = 0, y = 0;
    std::uint32_t width = 0, height = 0;  // within the window
};

// Use from one thread.
class Presenter {
  public:
    // Takes ownership of the surface. The device must have VK_KHR_swapchain. Throws GpuError if it cannot
    // present to the surface.
    Presenter(const Gpu&, VkSurfaceKHR);
    ~Presenter();
    Presenter(const Presenter&) = delete;
    Presenter& operator=(const Presenter&) = delete;

    // sRGB, four bytes per pixel, rows from the top. Copied before the call returns.
    void setPicture(std::size_t id, std::uint32_t width, std::uint32_t height,
                    std::span<const std::uint8_t> rgba);
    // Shows the pictures, later ones over earlier ones, on a background in linear light. Returns false if no
    // image became free within `timeout_ns`, if the window is not visible, or if its size has just changed:
    // try again. May block indefinitely on the display. Throws GpuError when the surface is lost.
    bool show(std::uint32_t width, std::uint32_t height, std::span<const PlacedPicture>,
              const std::array<float, 3>& background, std::uint64_t timeout_ns);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
