// Data between the frame thread and the window thread: pictures and numbers to the window, requests back.
// Neither side ever waits for the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "app/trainer/session/frame_state.h"
#include "app/trainer/view/pictures.h"
#include "app/trainer/window/orbit.h"
#include "base/rings.h"
#include "render/render.h"

namespace stylet::trainer {

struct EyeUpdate {
    render::Image image;  // alpha 0: a screen beneath the eye image is visible there
    int eye = 0;          // 0 left, 1 right
    render::View view;
    render::ScreenPlaces screens;
};
// Picture on an equipment screen.
struct ScreenUpdate {
    render::Image image;
    std::uint64_t maker = 0, revision = 0;  // the picture has changed if either has changed
    std::int64_t shown_ns = 0;              // steady clock: when it was last up to date
};

// Data of a frame for the metrics and the free camera.
struct StateUpdate {
    FrameState seen;
    double tick_s = 0.001;
    FrameTime time;  // timing of the previous frame, if this frame's is not known yet
    std::optional<double> hand_offset_m = {};  // distance between the drawn needle and the felt needle
    Attention attention = Attention::absent;
    bool headset = true;  // a headset is in use
};
// One per frame. No sample is lost as long as the window reads fast enough.
struct FrameSample {
    double time_s = 0.0, frame_ms = 0.0, depth_m = 0.0;
    double force_n = 0.0;  // of the tool in hand (toolForce_n())
    double other_n = 0.0;  // of a needle on the other segmentation; without one, the same as force_n
};

struct MirrorRequests {
    int eye = -1;                  // 0 left, 1 right, -1 none
    std::uint32_t max_pixels = 0;  // largest edge length that the window can use
    std::int64_t every_ns = 0;     // shortest interval between pictures that the window can use
    // Draw these screens even while nobody in the headset looks at them.
    bool ultrasound = false, xray = false;
    std::int64_t screens_every_ns = 0;  // shortest interval between their pictures
    // Without a headset (Desktop): size of the picture and viewpoint. No viewpoint: the operator's place.
    std::optional<Orbit> camera = {};
    std::uint32_t width = 0, height = 0;
};

struct MirrorChannels {
    // Frame thread writes, window thread reads.
    Latest<EyeUpdate> eye;
    Latest<ScreenUpdate> ultrasound, xray, monitor;
    Latest<StateUpdate> state;
    Ring<FrameSample> samples{1024};
    std::uint64_t makers = 0;  // frame thread: number of screen sources so far, one per headset
    // Window thread writes, frame thread reads.
    Snapshot<MirrorRequests> requests;
    std::atomic<bool> open{false};  // false once the window is closed or its display is lost
};

}  // namespace stylet::trainer
