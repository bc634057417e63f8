// A headset, from the time it is found until it is lost: the OpenXR session, the GPU that the runtime
// requires, and everything created on that GPU. After a loss the whole object is destroyed and a new one is
// created. Frame thread.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>

#include "app/trainer/display/frames.h"
#include "app/trainer/display/panels.h"
#include "app/trainer/view/equipment_pictures.h"
#include "app/trainer/window/mirror_feed.h"
#include "render/render.h"
#include "xr/xr.h"

namespace stylet::trainer {

inline constexpr auto kStartPatience = std::chrono::seconds(10);  // timeout for a slow runtime

std::array<render::View, 2> eyeViews(const xr::Frame&, const Pose& room_from_stage);
// Head pose: midway between the eyes, with the orientation of the left eye.
Pose headPose(const std::array<render::View, 2>&);
// Hooks through which the session creates the GPU. The session must be destroyed before the GPU.
render::GpuHooks makeGpuHooks(xr::Session&);

struct Headset {
    // Throws DataError, render::GpuError, or xr::XrError if there is no runtime or headset. The patient must
    // outlive this object.
    Headset(const patient::Patient&, const PictureSettings&);

    // Waits until frames can be submitted. Throws xr::XrError on timeout.
    void waitUntilRunning(std::chrono::seconds patience);
    // Adapts the resolution to the frame budget: `budget_ms`, or by default the runtime's frame period. A
    // software GPU has no default budget.
    void adaptToBudget(const xr::Frame&, std::optional<double> budget_ms);

    // Updates the area of an eye's image that the lens hides. Nothing is drawn in that area.
    void updateHiddenArea(int eye);
    // Returns the panels of this headset. They are created with its first frame, because that gives the pixel
    // density.
    HeadsetPanels& panelsFor(const xr::Frame&);

    // The session creates the GPU through hooks and must be destroyed before the GPU.
    std::shared_ptr<render::Gpu> gpu;  // outlives the session, which shares ownership
    xr::Session session;
    std::optional<render::Renderer> renderer;
    std::optional<EquipmentPictures> equipment_pictures;
    std::optional<HeadsetPanels> panels;
    render::RenderSettings drawn;
    std::optional<render::Governor> governor;
    std::optional<MirrorFeed> mirror;  // created once a window is connected
};

}  // namespace stylet::trainer
