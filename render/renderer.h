// Draws a RenderScene into both eyes of a stereo target in one pass where the driver really can.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include "render/gpu.h"
#include "render/scene.h"

namespace stylet::render {

// An image with two layers, left and right eye, as an OpenXR swapchain hands it out (COLOR_ATTACHMENT_OPTIMAL
// before and after).
struct StereoTarget {
    VkImage image = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_R8G8B8A8_SRGB;
    std::uint32_t width = 0, height = 0;
};

struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  // sRGB, rows from the top
};

class Renderer {
  public:
    // `assets` holds rooms/ and instruments/. Throws GpuError, patient::DataError.
    Renderer(Gpu&, const RenderSettings&, const std::filesystem::path& assets);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    void setSettings(const RenderSettings&);
    // Uploads CT and labels and builds the brick structure. The patient must outlive the renderer.
    void setPatient(const patient::Patient&);
    // Draws and waits for the GPU. Frame thread.
    RenderStats draw(const RenderScene&, const std::array<View, 2>&, const StereoTarget&);
    // The same into images of the renderer's own, read back: tests, benches, the README's picture.
    std::array<Image, 2> drawToImages(const RenderScene&, const std::array<View, 2>&, std::uint32_t width,
                                      std::uint32_t height, RenderStats* stats = nullptr);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
