// The frame loop: a headset, and after a loss another one, shown what the haptics loop last published. Frame
// thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/trainer/colocation.h"
#include "app/trainer/machine_pictures.h"
#include "app/trainer/pictures.h"
#include "app/trainer/staging.h"
#include "app/trainer/wounds.h"
#include "haptics/haptics.h"
#include "render/scene.h"

namespace stylet::trainer {

struct FrameSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};  // file; empty: none
    bool validation = false;                 // Vulkan's validation layer; its messages are counted
    bool virtual_clock = false;              // the mock runtime's time is its frame count: nothing sleeps
    std::filesystem::path capture_dir;       // where the mock runtime puts the pictures of moments
    std::filesystem::path head_script;       // as MockSettings::scenario
    render::Look look = render::Look::reveal;
    std::optional<double> budget_ms{};              // as in PictureSettings
    const haptics::TouchMap* touch = nullptr;       // as in PictureSettings
    std::string rearm_act{};                        // as in LiveHand
    std::optional<Colocation> colocation{};         // the device's place in the room
    bool seated = false;                            // the room comes down to the eyes of who sits
    std::shared_ptr<ControllerPort> controllers{};  // as in PictureSettings, with the next
    ControllerSide controller_side = ControllerSide::right;
    std::shared_ptr<Ears> ears{};  // as in PictureSettings, with the next
    training::Difficulty difficulty = training::Difficulty::practice;
    bool passthrough = false;  // the real room behind what is drawn, where the headset can
    double tick_s = 0.001;
    haptics::GuideSettings guide{};
    render::RenderSettings render{};
};

struct FrameTotals {
    std::vector<FrameTime> times;  // as in PictureTotals
    std::uint64_t frames = 0, rendered = 0;
    std::optional<FirstPicture> first;
    render::RenderStats sum;  // over all frames
    MachineTotals machines;
    std::uint64_t panels_drawn = 0, unseen_panels = 0;  // of the guide panel: pictures; frames without
    std::uint64_t validation_messages = 0;
    std::uint64_t headsets_found_again = 0;  // after a loss
    std::string runtime, gpu;
};

struct MirrorChannels;

class FrameLoop {
  public:
    // Throws xr::XrError without a runtime or headset, render::GpuError, patient::DataError. The patient must
    // outlive the loop. Settings for the mock runtime take effect only when it is the one the loader takes.
    FrameLoop(const patient::Patient&, const FrameSettings&, const patient::PlannedPath&);
    ~FrameLoop();
    FrameLoop(const FrameLoop&) = delete;
    FrameLoop& operator=(const FrameLoop&) = delete;

    // One frame of what `Seen` says; a non-empty moment is captured under that name. False when the runtime
    // wants the program to end. A lost session or instance is no end: the frames are empty until there is
    // another one. `contrast` is null until some was injected. Throws render::GpuError.
    bool frame(const Seen&, const patient::ContrastTable* contrast, const std::string& moment);
    // As in Pictures.
    void follow(LiveSeen);
    // From now on the window behind these channels is given what it asks for; they must outlive the loop.
    void mirrorTo(MirrorChannels&);
    // As of the last frame.
    Attention attention() const;
    FrameTotals totals() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
