// Interface to the frame loop, which may be missing. The build selects the implementation (pictures_gpu.cpp
// or pictures_none.cpp). openPictures() also fails at run time if there is no OpenXR runtime.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/report/film.h"
#include "app/trainer/attempt/config.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/window_port.h"
#include "app/trainer/session/colocation.h"
#include "app/trainer/session/frame_state.h"
#include "app/trainer/session/imaging_input.h"
#include "app/trainer/sound/listener_pose.h"
#include "app/trainer/stores/start.h"
#include "app/trainer/view/contacts.h"
#include "app/trainer/view/prediction.h"
#include "base/rings.h"
#include "haptics/haptics.h"
#include "patient/displacement/tool_displacement.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

inline constexpr std::size_t kMaxFrameTimes = 1u << 20;  // 3 hours at 90 Hz

struct PictureSettings {
    AttemptConfig config{};
    std::filesystem::path assets{};
    std::filesystem::path pipeline_cache{};  // compiled shaders of earlier runs; empty: none
    // Data of the attempt.
    PressInput press{};
    OperativeField field{};  // that the room is arranged around
    // Data of the input device.
    std::string rearm_act{};                 // see LiveHand; empty: the attempt has no user who could re-arm
    std::optional<Colocation> colocation{};  // place of a registered device in the room
    // Connections to other threads. Shared: a frame thread that hangs may outlive the attempt.
    std::shared_ptr<ControllerPort> controllers{};  // receives the state of the controller with the tool
    std::shared_ptr<WindowPort> window{};           // receives commands and motions from the window
    std::shared_ptr<ListenerPose> listener_pose{};  // receives the head pose every frame
    // Only for the mock runtime: see MockSettings::scenario.
    std::filesystem::path head_script{};
};

// Timing of one frame, and the error of its predicted tip at the display time (prediction.h).
struct FrameTime {
    std::uint64_t tick = 0;  // the tick that is shown
    double frame_ms = 0.0;   // from locating the eyes to submitting the picture
    double opaque_ms = 0.0, volume_ms = 0.0;
    double layer_scale = 0.0;
    std::optional<TipOffset> tip{};
    // Submitted after its display time. The tip was then predicted for a time before the user saw it.
    bool late = false;
};

struct PictureTotals {
    std::uint64_t frames = 0, rendered = 0, validation_messages = 0;
    std::uint64_t headsets_found_again = 0;  // after a loss
    std::uint64_t scans = 0, xray_pictures = 0;
    double ultrasound_ms = 0.0, xray_ms = 0.0;  // sums of wall time
    std::vector<FrameTime> times;               // frame times of the first kMaxFrameTimes frames
    std::optional<FirstPicture> first;
    std::string runtime, gpu;
    std::vector<std::pair<std::string, std::uint64_t>> skips;  // counters of skipped work, with their names
};

// Whether the user is looking.
enum class Attention : std::uint8_t {
    absent,   // there is no session, or it has not had the focus yet
    focused,  // the session has the focus and the headset is worn
    away      // the session has lost the focus or the headset was taken off: the attempt is paused
};
// Next state, for a frame with a session.
constexpr Attention attentionAfter(Attention before, bool focused) {
    if (focused) return Attention::focused;
    return before == Attention::absent ? Attention::absent : Attention::away;
}

// Lets a frame update its state after it has begun, because beginning a frame may block for a while.
struct LiveUpdates {
    Ring<haptics::TipSample>* tips = nullptr;
    std::function<void(FrameState&)> refresh;
    std::function<void(Attention)> on_attention;  // called immediately, before anything slow
};

// Shows an attempt in a headset or in a window. Frame thread only.
class Display {
  public:
    Display() = default;
    virtual ~Display() = default;
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    // Draws one frame. If `moment` is not empty, also saves the frame under that name. Returns false when the
    // runtime or the user asks to end. `contrast` is null until contrast medium is injected. Throws
    // std::runtime_error if the GPU or the runtime is lost.
    virtual bool frame(const FrameState&, const patient::ContrastTable* contrast,
                       const std::string& moment) = 0;
    virtual PictureTotals totals() const = 0;
    // State as of the last frame. A window always counts as focused.
    virtual Attention attention() const { return Attention::focused; }
    // Call before the first frame. A headset then updates the state of every frame except captures through
    // LiveUpdates. Without this call, frames show exactly the state that is passed in.
    virtual void follow(LiveUpdates) {}
    // Reason why frame() returned false.
    virtual const char* endReason() const { return "the OpenXR runtime ended the session"; }
};

// Opens a headset. Returns null if that is not possible. `why_not` is then one line that says what was looked
// for, where, and what was missing.
std::unique_ptr<Display> openPictures(const patient::Patient&, const patient::PlannedPath&,
                                      const PictureSettings&, std::string& why_not);

// Same without a headset: opens a window instead, if a display is available. frame() returns false once the
// window is closed.
std::unique_ptr<Display> openDesktop(const patient::Patient&, const patient::PlannedPath&,
                                     const PictureSettings&, std::string& why_not);

// Drops the alpha channel.
inline std::vector<std::uint8_t> rgbOf(std::span<const std::uint8_t> rgba) {
    std::vector<std::uint8_t> rgb;
    rgb.reserve(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i + 4 <= rgba.size(); i += 4)
        rgb.insert(rgb.end(), &rgba[i], &rgba[i] + 3);
    return rgb;
}
struct EyePicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // packed triples, rows from the top
};
inline report::FilmFrame filmFrame(EyePicture&& eye, const std::string& caption) {
    return {eye.width, eye.height, std::move(eye.rgb), caption};
}
struct StereoShot {
    patient::Surrogate breath{};
    bool closed = false;                 // true: closed skin; false: the anatomy beneath is visible
    std::optional<double> distance_m{};  // from the eyes to the path's entry; absent: show the whole patient
    int pixels = 640;
    bool across_the_room = false;               // view from the door across the whole room
    std::vector<patient::PlannedPath> paths{};  // coloured by quality
    bool section = false;                       // cut the patient transversely at the path's entry
    std::vector<Wound> wounds{};
    std::optional<Pose> patient_from_needle{};
    const patient::DisplacementTable* tool = nullptr;  // tissue displacement by a tool; null: none
};
// Renders stereo pictures without a headset or an OpenXR runtime, for films and contact sheets. Use from one
// thread only.
struct StereoView {
    std::function<std::array<EyePicture, 2>(const StereoShot&)> draw;
    std::string gpu;
};
std::optional<StereoView> openStereo(const patient::Patient&, const patient::PlannedPath&,
                                     const std::filesystem::path& assets, std::string& why_not);

// Screens of the ultrasound machine and the C-arm.
struct EquipmentView {
    std::function<EyePicture(const ImagingInput&)> ultrasound, xray;
    std::string gpu;
};
std::optional<EquipmentView> openEquipment(const patient::Patient&, const std::filesystem::path& assets,
                                           std::string& why_not);

}  // namespace stylet::trainer
