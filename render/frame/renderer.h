// Draws a RenderScene into both eyes of a stereo target, in one pass where the driver supports it.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "render/gpu/gpu.h"
#include "render/scene/scene.h"
#include "render/volume/deformed_patient.h"
#include "render/volume/look.h"

namespace stylet::render {

// An image with two layers, left and right eye, as acquired from an OpenXR swapchain. It is in
// COLOR_ATTACHMENT_OPTIMAL before and after.
struct StereoTarget {
    VkImage image = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_R8G8B8A8_SRGB;
    std::uint32_t width = 0, height = 0;
    // Optional: D32_SFLOAT with two layers, in DEPTH_STENCIL_ATTACHMENT_OPTIMAL before and after. Receives
    // the depth of the first nearly opaque surface, reversed: near_m at 1, far_m at 0.
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
    // `assets`: folder with looks/, rooms/ and instruments/. Throws GpuError, DataError.
    Renderer(Gpu&, const RenderSettings&, const std::filesystem::path& assets);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    void setSettings(const RenderSettings&);
    // Replaces one of the two looks loaded from assets/looks/*.toml.
    void setLook(Look, const LookStyle&);
    // Sets the part of an eye's picture that the lens hides (XR_KHR_visibility_mask), as triangles.
    // Vertices are tangents of the angles right and up of the optical axis. Nothing is drawn there.
    void setHiddenArea(int eye, std::span<const glm::vec2> tangents, std::span<const std::uint32_t> indices);
    // Uploads CT and labels and builds the brick structure. The patient must outlive the renderer. If the
    // device cannot hold the patient at full resolution, it is shown in coarser voxels and notes() says so.
    void setPatient(const patient::Patient&);
    // The deformed patient (breath and tool) of the drawn frame, for other pictures of the same state.
    // Requires a patient.
    DeformedPatient& deformedPatient();
    const std::vector<std::string>& notes() const;  // reductions in quality, one sentence each
    // Pose of the C-arm's isocentre, as FluoroscopyInput needs it. The scene must have a C-arm.
    Pose patientFromIsocentre(const RenderScene&) const;
    // Returns which screens these views will see. Allocates nothing.
    VisibleScreens visibleScreens(const RenderScene&, const std::array<View, 2>&) const;
    // Returns the pose and size of each screen in the scene's room.
    ScreenPlaces screenPlaces(const RenderScene&) const;
    // Frame thread. Draws and waits for the GPU. Images that were drawn to are cached by their handle and
    // must outlive the renderer.
    RenderStats draw(const RenderScene&, const std::array<View, 2>&, const StereoTarget&);
    // Draws into images of its own and reads them back, for tests, benches and the README's picture.
    std::array<Image, 2> drawToImages(const RenderScene&, const std::array<View, 2>&, std::uint32_t width,
                                      std::uint32_t height, RenderStats* stats = nullptr,
                                      std::array<DepthImage, 2>* depths = nullptr);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
