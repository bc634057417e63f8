// Data between the frame thread and the window thread: pictures and numbers to the window, requests back.
// Neither side ever waits for the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "app/trainer/session/seen.h"
#include "app/trainer/view/pictures.h"
#include "app/trainer/window/latest.h"
#include "app/trainer/window/orbit.h"
#include "base/rings.h"
#include "render/render.h"

namespace stylet::trainer {

struct EyeGiven {
    render::Image image;  // alpha 0: a screen beneath the eye image is visible there
    int eye = 0;          // 0 left, 1 right
    render::View view;
    render::ScreenPlaces screens;
};
// Picture on an equipment screen.
struct ScreenGiven {
    render::Image image;
    std::uint64_t maker = 0, revision = 0;  // the picture has changed if either has changed
    std::int64_t shown_ns = 0;              // steady clock: when it was last up to date
};

// Data of a frame for the metrics and the free camera.
struct StateGiven {
    Seen seen;
    double tick_s = 0.001;
    FrameTime time;                            // of the previous frame if not known yet
    std::optional<double> hand_offset_m = {};  // between the needle that is seen and the needle that is felt
    Attention attention = Attention::absent;
    bool headset = true;  // a headset is in use
};
// One per frame. None is lost while the window keeps up.
struct FrameSample {
    double time_s = 0.0, frame_ms = 0.0, force_n = 0.0, depth_m = 0.0;
    double other_n = 0.0;  // force on the other segmentation; else the same as force_n
};

struct MirrorWants {
    int eye = -1;                   // 0 left, 1 right, -1 none
    std::uint32_t most_pixels = 0;  // largest useful edge length
    std::int64_t every_ns = 0;      // shortest useful interval between pictures
    // Draw these screens even while nobody in the headset looks at them.
    bool ultrasound = false, xray = false;
    // Without a headset (Desktop): viewpoint, by default the operator's place, and size of the picture.
    std::optional<Orbit> camera = {};
    std::uint32_t width = 0, height = 0;
};

struct MirrorChannels {
    // Frame thread writes, window thread reads.
    Latest<EyeGiven> eye;
    Latest<ScreenGiven> ultrasound, xray, monitor;
    Latest<StateGiven> state;
    Ring<FrameSample> samples{1024};
    std::uint64_t makers = 0;  // frame thread: number of screen sources so far, one per headset
    // Window thread writes, frame thread reads.
    Snapshot<MirrorWants> wants;
    std::atomic<bool> open{false};  // false once the window is closed or its display is lost
};

}  // namespace stylet::trainer
