// The frame thread's side of the window: what it asked for, given without waiting. As long as its GPU.
#pragma once

#include <array>

#include "app/trainer/machine_pictures.h"
#include "app/trainer/window/mirror_channels.h"
#include "render/render.h"

namespace stylet::trainer {

// Frame thread, all of it.
class MirrorFeed {
  public:
    // Both must outlive it. `tick_s`: of the shown ticks.
    MirrorFeed(MirrorChannels&, const render::Gpu&, double tick_s);

    // At the beginning of a frame: the machines whose pictures are to be made, those that an eye sees and
    // those that the window asks for.
    render::ScreensSeen screens(const render::ScreensSeen& seen);
    // Between drawing and giving the image to the runtime: submits the copy of the eye that is wanted.
    void copyEye(const render::StereoTarget&, const std::array<render::View, 2>&, const render::ScreenPlaces&,
                 const render::ScreenPicture& monitor);
    // After the frame: hands over the last copy that has come, the screens, and the numbers.
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
    std::array<Copied, 4> copied_{};  // by the copy's number
    std::uint64_t copies_ = 0;
    std::uint64_t maker_;
};

// A screen's picture into its channel; `up_to_date`: it was made, or found unchanged, for this frame.
void giveScreen(Latest<ScreenGiven>&, const render::ScreenPicture&, bool up_to_date, std::uint64_t maker);
// The numbers of a frame. `headset`: there is one.
void giveState(MirrorChannels&, const Seen&, double tick_s, const FrameTime&, Attention, bool headset,
               std::optional<double> hand_offset_m = {});

}  // namespace stylet::trainer
