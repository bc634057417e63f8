// Pictures from host memory on a window's surface: placed and scaled, not blended. Whoever made the surface
// owns the window and its events.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "render/gpu.h"

namespace stylet::render {

struct Placed {
    std::size_t picture = 0;  // as given to setPicture
    std::int32_t x = 0, y = 0;
    std::uint32_t width = 0, height = 0;  // within the window
};

// One thread.
class Presenter {
  public:
    // Takes the surface, of a device with VK_KHR_swapchain; GpuError where it cannot show anything on it.
    Presenter(const Gpu&, VkSurfaceKHR);
    ~Presenter();
    Presenter(const Presenter&) = delete;
    Presenter& operator=(const Presenter&) = delete;

    // sRGB, four bytes a pixel, rows from the top. Read at once.
    void setPicture(std::size_t id, std::uint32_t width, std::uint32_t height,
                    std::span<const std::uint8_t> rgba);
    // Shows the pictures, later ones over earlier ones, on a background in linear light. False when the
    // window had no room for one within the patience, is not to be seen, or has just changed its size: try
    // again. May wait for the display for as long as it likes. Throws GpuError when the surface is lost.
    bool show(std::uint32_t width, std::uint32_t height, std::span<const Placed>,
              const std::array<float, 3>& background, std::uint64_t patience_ns);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
