// The frame loop: an OpenXR session shown what the haptics loop last published. Frame thread only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/trainer/staging.h"
#include "haptics/haptics.h"
#include "render/scene.h"

namespace stylet::trainer {

struct FrameSettings {
    std::filesystem::path assets;
    bool validation = false;            // Vulkan's validation layer; its messages are counted
    bool virtual_clock = false;         // the mock runtime's time is its frame count: nothing sleeps
    std::filesystem::path capture_dir;  // where the mock runtime puts the pictures of moments
    std::filesystem::path head_script;  // the mock runtime's head; empty: written from the planned path
    render::RenderSettings render{.count = true};  // the work done and skipped is reported
};

struct FrameTotals {
    std::uint64_t frames = 0, rendered = 0;
    render::RenderStats sum;  // over all frames
    std::uint64_t validation_messages = 0;
    double median_frame_ms = 0;  // from the views to the submitted picture
    std::string runtime, gpu;
};

class FrameLoop {
  public:
    // Throws xr::XrError without a runtime or headset, render::GpuError, patient::DataError. The patient must
    // outlive the loop. Settings for the mock runtime take effect only when it is the one the loader takes.
    FrameLoop(const patient::Patient&, const FrameSettings&, const patient::PlannedPath&);
    ~FrameLoop();
    FrameLoop(const FrameLoop&) = delete;
    FrameLoop& operator=(const FrameLoop&) = delete;

    // One frame of what `shown` says; a non-empty moment is captured under that name. False when the session
    // ended.
    bool frame(const haptics::TickOutput& shown, const std::string& moment);
    // As of the last frame: the session has the focus, which a headset taken off loses.
    bool focused() const;
    FrameTotals totals() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
