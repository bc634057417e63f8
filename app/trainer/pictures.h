// The frame loop as the rest of the trainer sees it: something that may draw, or nothing. Which of the two is
// decided by the build (pictures_gpu.cpp or pictures_none.cpp) and, at run time, by whether a runtime
// answers.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/report/film.h"
#include "app/trainer/colocation.h"
#include "app/trainer/controller_hand.h"
#include "app/trainer/machine_moment.h"
#include "app/trainer/prediction.h"
#include "app/trainer/seen.h"
#include "app/trainer/sound/ears.h"
#include "app/trainer/start.h"
#include "app/trainer/window_port.h"
#include "app/training/difficulty.h"
#include "haptics/haptics.h"
#include "patient/planning.h"
#include "patient/tool_displacement.h"

namespace stylet::trainer {

inline constexpr std::size_t kMostFrameTimes = 1u << 20;  // three hours at 90 a second

struct PictureSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};  // compiled shaders of earlier runs; empty: none
    std::filesystem::path capture_folder;    // where the mock runtime puts the eyes' PNGs
    bool validation = false;
    bool virtual_clock = false;
    bool closed_look = false;
    bool count = false;  // rays and samples, which costs a GPU some atomic additions a ray
    // That the resolution keeps to; absent: a GPU keeps to the runtime's pace, a processor to none.
    std::optional<double> budget_ms;
    const haptics::TouchMap* touch = nullptr;  // of the skin that finger and probe are seen to press
    std::string rearm_act{};                   // as in LiveHand; empty: nobody can
    std::optional<Colocation> colocation{};    // of a registered device
    bool seated = false;                       // the room comes down to the eyes of who sits
    // Told of the controller that has the tool. Shared: a frame thread that is stuck outlives the attempt.
    std::shared_ptr<ControllerPort> controllers{};
    ControllerSide controller_side = ControllerSide::right;
    std::shared_ptr<WindowPort> window{};  // told what is said and done in the window; shared likewise
    double tick_s = 0.001;                 // of the shown ticks
    haptics::GuideSettings guide{};        // on the probe: its line stands in the ultrasound picture
    bool mirror = false;                   // a window for who has no headset on, where a display answers
    bool passthrough = false;              // the real room behind what is drawn, where the headset can
    bool foveation = false;                // fewer rays beside the middle of the view
    std::shared_ptr<Ears> ears{};          // told where the head is, each frame
    training::Difficulty difficulty = training::Difficulty::practice;
};

// What one frame took, and how far its tip was from where it was at the display time (prediction.h).
struct FrameTime {
    std::uint64_t tick = 0;  // that it shows
    double frame_ms = 0.0;   // from the views to the submitted picture
    double opaque_ms = 0.0, volume_ms = 0.0;
    double layer_scale = 0.0;
    std::optional<TipOffset> tip{};
    bool late = false;  // handed over after its display time: it was seen later than the tip was drawn for
};

struct PictureTotals {
    std::uint64_t frames = 0, rendered = 0, validation_messages = 0;
    std::uint64_t headsets_found_again = 0;  // after a loss
    std::uint64_t scans = 0, xray_pictures = 0;
    double ultrasound_ms = 0.0, xray_ms = 0.0;  // sums
    std::vector<FrameTime> times;               // of the first kMostFrameTimes
    std::optional<FirstPicture> first;
    std::string runtime, gpu;
    std::vector<std::pair<std::string, std::uint64_t>> skips;  // counters of work left out
};

// Whether somebody looks.
enum class Attention : std::uint8_t {
    absent,   // not yet, or not any more: there is no session, or it has not had the focus so far
    focused,  // the session has the focus and the headset is worn
    away      // it had: the attempt waits for its user
};
// With a session: what comes after `before`.
constexpr Attention attentionAfter(Attention before, bool focused) {
    if (focused) return Attention::focused;
    return before == Attention::absent ? Attention::absent : Attention::away;
}

// What a frame brings up to date once it has begun, which may have waited for a while.
struct LiveSeen {
    haptics::Ring<haptics::TipSample>* tips = nullptr;
    std::function<void(Seen&)> refresh;
    std::function<void(Attention)> tell;  // at once, before anything that may take its time
};

// Frame thread only. `frame` draws one display time, false when the runtime asks to end; a named moment is
// captured. Throws std::runtime_error when GPU or runtime are lost.
struct Pictures {
    // `contrast` is null until some was injected.
    std::function<bool(const Seen&, const patient::ContrastTable* contrast, const std::string& moment)> frame;
    std::function<PictureTotals()> totals;
    std::function<Attention()> attention = nullptr;  // as of the last frame; absent: always focused
    // Before the first frame: from now on all but moments are brought up to date. Absent: frames show what
    // they are given, as on a virtual clock.
    std::function<void(LiveSeen)> follow = nullptr;
    const char* ended = "the OpenXR runtime ended the session";  // when `frame` is false
};

// Empty when no pictures can be made; then `why_not` is one line: what was looked for, where, what was
// missing.
std::optional<Pictures> openPictures(const patient::Patient&, const patient::PlannedPath&,
                                     const PictureSettings&, std::string& why_not);

// The same without a headset: a window in its place, where a display answers. `frame` is false once it was
// closed.
std::optional<Pictures> openDesktop(const patient::Patient&, const patient::PlannedPath&,
                                    const PictureSettings&, std::string& why_not);

// What the eyes of somebody without a headset see: pictures for films and sheets. No runtime has a part in
// it. One thread.
struct EyePicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // packed triples, rows from the top
};
inline report::FilmFrame filmFrame(EyePicture&& eye, const std::string& caption) {
    return {eye.width, eye.height, std::move(eye.rgb), caption};
}
struct StereoShot {
    patient::Surrogate breath{};
    bool closed = false;                 // the look: closed skin, else what lies beneath
    std::optional<double> distance_m{};  // of the eyes from the path's entry; absent: the whole patient
    int pixels = 640;
    bool across_the_room = false;               // from the door, over everything
    std::vector<patient::PlannedPath> paths{};  // coloured by how good they are
    bool section = false;                       // the patient cut across at the path's entry
    std::vector<Wound> wounds{};
    std::optional<patient::Pose> patient_from_needle{};
    const patient::DisplacementTable* tool = nullptr;  // what a tool displaces; null: nothing
};
struct StereoView {
    std::function<std::array<EyePicture, 2>(const StereoShot&)> draw;
    std::string gpu;
};
std::optional<StereoView> openStereo(const patient::Patient&, const patient::PlannedPath&,
                                     const std::filesystem::path& assets, std::string& why_not);

// The glass of the machines' screens.
struct MachineView {
    std::function<EyePicture(const MachineMoment&)> ultrasound, xray;
    std::string gpu;
};
std::optional<MachineView> openMachines(const patient::Patient&, const std::filesystem::path& assets,
                                        std::string& why_not);

}  // namespace stylet::trainer
