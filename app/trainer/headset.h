// A headset from when it is found until it is lost: the OpenXR session, the GPU that the runtime names, and
// what is made on it. After a loss it is destroyed whole, and another one is made. Frame thread.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>

#include "app/trainer/frames.h"
#include "app/trainer/machine_pictures.h"
#include "app/trainer/panels.h"
#include "app/trainer/window/mirror_feed.h"
#include "render/render.h"
#include "xr/xr.h"

namespace stylet::trainer {

inline constexpr auto kStartPatience = std::chrono::seconds(10);  // with a runtime that is slow to begin

patient::Pose poseOf(const xr::Pose&);
xr::Pose poseOf(const patient::Pose&);
std::array<render::View, 2> viewsOf(const xr::Frame&, const patient::Pose& room_from_stage);
// Between the eyes, turned as the left one is.
patient::Pose headOf(const std::array<render::View, 2>&);
// The session makes the GPU and must be gone before it is.
render::GpuHooks hooksOf(xr::Session&);

struct Headset {
    // Throws xr::XrError without a runtime or headset, render::GpuError, patient::DataError. The patient must
    // outlive it.
    Headset(const patient::Patient&, const FrameSettings&);

    // Until frames may be made. Throws xr::XrError when the runtime takes longer than that.
    void waitUntilRunning(std::chrono::seconds patience);
    // The resolution follows the budget: what was asked for, or the runtime's pace where a GPU can be
    // expected to hold it.
    void keepToBudget(const xr::Frame&, std::optional<double> budget_ms);

    // Nothing is drawn there from now on.
    void hideWhatTheLensHides(int eye);
    // Those of this headset; its first frame says how fine it is.
    HeadsetPanels& panelsFor(const xr::Frame&);

    // The session asks for its GPU through hooks and must be gone before the device is.
    std::shared_ptr<render::Gpu> gpu;  // outlives the session, which keeps it
    xr::Session session;
    std::optional<render::Renderer> renderer;
    std::optional<MachinePictures> machines;
    std::optional<HeadsetPanels> panels;
    render::RenderSettings drawn;
    std::optional<render::Governor> governor;
    std::optional<MirrorFeed> mirror;  // made when a window is there
};

}  // namespace stylet::trainer
