// The frame thread's side of the window: delivers what the window requested, without waiting. It lives as
// long as its GPU.
#pragma once

#include <array>

#include "app/trainer/view/machine_pictures.h"
#include "app/trainer/window/mirror_channels.h"
#include "render/render.h"

namespace stylet::trainer {

// Frame thread only.
class MirrorFeed {
  public:
    // Both must outlive it. `tick_s`: period of the shown ticks.
    MirrorFeed(MirrorChannels&, const render::Gpu&, double tick_s);

    // Call at the start of a frame. Returns the equipment screens to draw: those that an eye sees and those
    // that the window requested.
    render::ScreensSeen screens(const render::ScreensSeen& seen);
    // Call between drawing an image and releasing it to the runtime. Submits a copy of the requested eye.
    void copyEye(const render::StereoTarget&, const std::array<render::View, 2>&, const render::ScreenPlaces&,
                 const render::ScreenPicture& monitor);
    // Call after the frame. Publishes the last finished copy, the screens and the numbers.
    void give(const Seen&, const MachinePictures&, const FrameTime&, Attention,
              std::optional<double> hand_offset_m = {});

  private:
    MirrorChannels* channels_;
    render::EyeTap tap_;
    double tick_s_;
    MirrorWants wants_;
    render::ScreensSeen made_;
    std::int64_t copied_ns_ = 0;
    struct Copied {
        int eye = 0;
        render::View view;
        render::ScreenPlaces screens;
    };
    std::array<Copied, 4> copied_{};  // indexed by the copy's number
    std::uint64_t copies_ = 0;
    std::uint64_t maker_;
};

// Publishes the picture of a screen. `up_to_date`: it was drawn, or found unchanged, for this frame.
void giveScreen(Latest<ScreenGiven>&, const render::ScreenPicture&, bool up_to_date, std::uint64_t maker);
// Publishes the state and the numbers of a frame.
void giveState(MirrorChannels&, StateGiven);

}  // namespace stylet::trainer
