// The frame loop renders the newest published haptics state to a headset. If the headset is lost, it searches
// for one again. Frame thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/wounds.h"
#include "app/trainer/view/equipment_pictures.h"
#include "app/trainer/view/pictures.h"
#include "haptics/haptics.h"
#include "render/render.h"

namespace stylet::trainer {

struct FrameTotals : PictureTotals {
    render::RenderStats sum;  // sum over all frames
    EquipmentTotals equipment;
    // Guide panel: number of redraws; frames in which it was out of view.
    std::uint64_t panels_drawn = 0, unseen_panels = 0;
};

struct MirrorChannels;

class FrameLoop {
  public:
    // Throws DataError, render::GpuError, or xr::XrError if there is no runtime or headset. The patient must
    // outlive the loop. Settings for the mock runtime take effect only if the loader selects the mock
    // runtime.
    FrameLoop(const patient::Patient&, const PictureSettings&, const patient::PlannedPath&);
    ~FrameLoop();
    FrameLoop(const FrameLoop&) = delete;
    FrameLoop& operator=(const FrameLoop&) = delete;

    // Renders one frame of this state. A non-empty `moment` captures the frame under that name. Returns false
    // when the runtime asks the program to end. If the session or the instance is lost, the loop continues
    // with empty frames until a headset is found again. `contrast` is null until contrast medium is injected.
    // Throws render::GpuError.
    bool frame(const FrameState&, const patient::ContrastTable* contrast, const std::string& moment);
    // See Display::follow().
    void follow(LiveUpdates);
    // Serves the requests of the window behind these channels. The channels must outlive the loop.
    void mirrorTo(MirrorChannels&);
    // State as of the last frame.
    Attention attention() const;
    FrameTotals totals() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
