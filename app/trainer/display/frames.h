// The frame loop: renders the newest published haptics state to a headset. After a loss it looks for a
// headset again. Frame thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/wounds.h"
#include "app/trainer/view/machine_pictures.h"
#include "app/trainer/view/pictures.h"
#include "haptics/haptics.h"
#include "render/render.h"

namespace stylet::trainer {

struct FrameTotals {
    std::vector<FrameTime> times;  // as in PictureTotals
    std::uint64_t frames = 0, rendered = 0;
    std::optional<FirstPicture> first;
    render::RenderStats sum;  // sum over all frames
    MachineTotals machines;
    std::uint64_t panels_drawn = 0, unseen_panels = 0;  // guide panel: redraws; frames out of view
    std::uint64_t validation_messages = 0;
    std::uint64_t headsets_found_again = 0;  // after a loss
    std::string runtime, gpu;
};

struct MirrorChannels;

class FrameLoop {
  public:
    // Throws xr::XrError without a runtime or headset, render::GpuError, DataError. The patient
    // must outlive the loop. Settings for the mock runtime take effect only if the loader selects the mock
    // runtime.
    FrameLoop(const patient::Patient&, const PictureSettings&, const patient::PlannedPath&);
    ~FrameLoop();
    FrameLoop(const FrameLoop&) = delete;
    FrameLoop& operator=(const FrameLoop&) = delete;

    // Renders one frame of this state. A non-empty `moment` captures the frame under that name. Returns
    // false when the runtime asks the program to end. A lost session or instance does not end the loop:
    // frames stay empty until a headset is found again. `contrast` is null until medium was injected.
    // Throws render::GpuError.
    bool frame(const Seen&, const patient::ContrastTable* contrast, const std::string& moment);
    // As in Display.
    void follow(LiveSeen);
    // Answers the requests of the window behind these channels. The channels must outlive the loop.
    void mirrorTo(MirrorChannels&);
    // As of the last frame.
    Attention attention() const;
    FrameTotals totals() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
