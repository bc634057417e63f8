// The frame thread's side of the window. Delivers the pictures and data that the window requested, without
// waiting. Destroyed before its GPU.
#pragma once

#include <array>

#include "app/trainer/view/equipment_pictures.h"
#include "app/trainer/window/mirror_channels.h"
#include "render/render.h"

namespace stylet::trainer {

// Frame thread only.
class MirrorFeed {
  public:
    // The channels and the GPU must outlive this object. `tick_s`: period of the shown ticks.
    MirrorFeed(MirrorChannels&, const render::Gpu&, double tick_s);

    // Call at the start of a frame. Returns the equipment screens to draw: those that an eye sees and those
    // that the window requested.
    render::VisibleScreens screens(const render::VisibleScreens& seen);
    // Call between drawing an image and releasing it to the runtime. Submits a copy of the requested eye.
    void copyEye(const render::StereoTarget&, const std::array<render::View, 2>&, const render::ScreenPlaces&,
                 const render::ScreenPicture& monitor);
    // Call after the frame. Publishes the last finished copy, the screens and the numbers.
    void publish(const FrameState&, const EquipmentPictures&, const FrameTime&, Attention,
                 std::optional<double> hand_offset_m = {});

  private:
    MirrorChannels* channels_;
    render::EyeTap tap_;
    double tick_s_;
    MirrorRequests requests_;
    render::VisibleScreens made_;
    std::int64_t copied_ns_ = 0, screens_ns_ = 0;  // steady clock: when each was requested last
    struct Copied {
        int eye = 0;
        render::View view;
        render::ScreenPlaces screens;
    };
    std::array<Copied, 4> copied_{};  // indexed by the copy's number
    std::uint64_t copies_ = 0;
    std::uint64_t maker_;
};

// Publishes the picture of a screen. `up_to_date`: the picture was drawn for this frame, or found unchanged.
void publishScreen(Latest<ScreenUpdate>&, const render::ScreenPicture&, bool up_to_date, std::uint64_t maker);
// Publishes the state and the numbers of a frame.
void publishState(MirrorChannels&, StateUpdate);

}  // namespace stylet::trainer
