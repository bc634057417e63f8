// The frame loop: renders the newest published haptics state to a headset. After a loss it looks for a
// headset again. Frame thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/colocation.h"
#include "app/trainer/session/wounds.h"
#include "app/trainer/view/machine_pictures.h"
#include "app/trainer/view/pictures.h"
#include "haptics/haptics.h"
#include "render/scene/scene.h"

namespace stylet::trainer {

struct FrameSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};  // file; empty: none
    bool validation = false;                 // Vulkan validation layer; its messages are counted
    bool virtual_clock = false;              // the mock runtime's time is its frame count; nothing sleeps
    std::filesystem::path capture_dir;       // where the mock runtime saves captures
    std::filesystem::path head_script;       // as MockSettings::scenario
    render::Look look = render::Look::reveal;
    std::optional<double> budget_ms{};              // as in PictureSettings
    const haptics::TouchMap* touch = nullptr;       // as in PictureSettings
    std::string rearm_act{};                        // as in LiveHand
    std::optional<Colocation> colocation{};         // pose of the device in the room
    bool seated = false;                            // seated mode: lower the stage to the user's eye height
    std::shared_ptr<ControllerPort> controllers{};  // as in PictureSettings, like the next member
    ControllerSide controller_side = ControllerSide::right;
    std::shared_ptr<Ears> ears{};  // as in PictureSettings, like the next member
    training::Difficulty difficulty = training::Difficulty::practice;
    bool passthrough = false;  // show the real room behind the scene, if the headset can
    double tick_s = 0.001;
    haptics::GuideSettings guide{};
    render::RenderSettings render{};
};

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
    FrameLoop(const patient::Patient&, const FrameSettings&, const patient::PlannedPath&);
    ~FrameLoop();
    FrameLoop(const FrameLoop&) = delete;
    FrameLoop& operator=(const FrameLoop&) = delete;

    // Renders one frame of this state. A non-empty `moment` captures the frame under that name. Returns
    // false when the runtime asks the program to end. A lost session or instance does not end the loop:
    // frames stay empty until a headset is found again. `contrast` is null until medium was injected.
    // Throws render::GpuError.
    bool frame(const Seen&, const patient::ContrastTable* contrast, const std::string& moment);
    // As in Pictures.
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
