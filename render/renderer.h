// Draws a RenderScene into both eyes of a stereo target in one pass where the driver really can.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "render/gpu.h"
#include "render/scene.h"
#include "render/volume/deformed_patient.h"
#include "render/volume/look.h"

namespace stylet::render {

// An image with two layers, left and right eye, as an OpenXR swapchain hands it out (COLOR_ATTACHMENT_OPTIMAL
// before and after).
struct StereoTarget {
    VkImage image = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_R8G8B8A8_SRGB;
    std::uint32_t width = 0, height = 0;
    // Optional: D32_SFLOAT with two layers, DEPTH_STENCIL_ATTACHMENT_OPTIMAL before and after. What hides
    // most of what is behind it, reversed: near_m at 1, far_m at 0.
    VkImage depth_image = VK_NULL_HANDLE;
};

struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  // sRGB, rows from the top
};

struct DepthImage {
    std::uint32_t width = 0, height = 0;
    std::vector<float> reversed;  // near_m at 1, far_m at 0, rows from the top
};

class Renderer {
  public:
    // `assets` holds rooms/ and instruments/. Throws GpuError, patient::DataError.
    Renderer(Gpu&, const RenderSettings&, const std::filesystem::path& assets);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    void setSettings(const RenderSettings&);
    // Another transfer function than assets/looks/*.toml in the place of one of the two.
    void setLook(Look, const LookStyle&);
    // The part of an eye's picture that no one can see (XR_KHR_visibility_mask): triangles over tangents of
    // the angles right and up of the optical axis. Nothing is drawn there.
    void setHiddenArea(int eye, std::span<const glm::vec2> tangents, std::span<const std::uint32_t> indices);
    // Uploads CT and labels and builds the brick structure. The patient must outlive the renderer. Where the
    // device cannot hold him as he is, he is shown in fewer voxels, and notes() says so.
    void setPatient(const patient::Patient&);
    // Who breathes and is pressed in what is drawn, for other pictures of the same moment. With a patient.
    DeformedPatient& deformedPatient();
    const std::vector<std::string>& notes() const;  // what is less than it should be, a sentence each
    // What the room's C-arm turns about, as Fluoroscopy asks for it. Of a scene with one.
    Pose patientFromIsocentre(const RenderScene&) const;
    // Which screens these views will see. Allocates nothing.
    ScreensSeen screensSeen(const RenderScene&, const std::array<View, 2>&) const;
    // Where the screens of such a room are.
    ScreenPlaces screenPlaces(const RenderScene&) const;
    // Draws and waits for the GPU. Frame thread. An image that was drawn to is remembered by its handle: it
    // must live for as long as this does.
    RenderStats draw(const RenderScene&, const std::array<View, 2>&, const StereoTarget&);
    // The same into images of the renderer's own, read back: tests, benches, the README's picture.
    std::array<Image, 2> drawToImages(const RenderScene&, const std::array<View, 2>&, std::uint32_t width,
                                      std::uint32_t height, RenderStats* stats = nullptr,
                                      std::array<DepthImage, 2>* depths = nullptr);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
