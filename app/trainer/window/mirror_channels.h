// What passes between the frame thread and the window's: pictures and numbers one way, wishes the other.
// Neither side ever waits for the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "app/trainer/pictures.h"
#include "app/trainer/seen.h"
#include "app/trainer/window/latest.h"
#include "app/trainer/window/orbit.h"
#include "haptics/rings.h"
#include "render/render.h"

namespace stylet::trainer {

struct EyeGiven {
    render::Image image;  // alpha 0: a screen that lies beneath the eyes' pictures is seen there
    int eye = 0;          // 0 left, 1 right
    render::View view;
    render::ScreenPlaces screens;
};
// The glass of a machine's screen.
struct ScreenGiven {
    render::Image image;
    std::uint64_t maker = 0, revision = 0;  // another of the two: another picture
    std::int64_t shown_ns = 0;              // steady clock: when it was up to date
};

// What the metrics and the free camera need of a frame.
struct StateGiven {
    Seen seen;
    double tick_s = 0.001;
    FrameTime time;                            // of the frame before, where it is not known yet
    std::optional<double> hand_offset_m = {};  // between the needle that is seen and the one that is felt
    Attention attention = Attention::absent;
    bool headset = true;  // there is one
};
// One a frame, none left out while the window keeps up.
struct FrameSample {
    double time_s = 0.0, frame_ms = 0.0, force_n = 0.0, depth_m = 0.0;
    double other_n = 0.0;  // the force over the other segmentation, where there is one
};

struct MirrorWants {
    int eye = -1;                   // 0 left, 1 right, -1 none
    std::uint32_t most_pixels = 0;  // along either edge: more would not be seen
    std::int64_t every_ns = 0;      // nor would pictures in quicker succession
    // Even while nobody in the headset looks at that screen.
    bool ultrasound = false, xray = false;
    // Without a headset (Desktop): from where, null: the operator's place; and of what shape.
    std::optional<Orbit> camera = {};
    std::uint32_t width = 0, height = 0;
};

struct MirrorChannels {
    // Frame thread writes, window thread reads.
    Latest<EyeGiven> eye;
    Latest<ScreenGiven> ultrasound, xray, monitor;
    Latest<StateGiven> state;
    haptics::Ring<FrameSample> samples{1024};
    std::uint64_t makers = 0;  // frame thread: of screens so far, a headset after the other
    // Window thread writes, frame thread reads.
    haptics::Snapshot<MirrorWants> wants;
    std::atomic<bool> open{false};  // false once it was closed or its display lost
};

}  // namespace stylet::trainer
