// The instructor's window: what the trainee sees, a free camera, the equipment screens and the numbers. It
// has a thread and a Vulkan device of its own. It may block, be minimised, closed or lost, and the headset
// never waits for it.
#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "app/trainer/hands/window_port.h"
#include "app/trainer/window/mirror_channels.h"
#include "app/training/difficulty.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// There is no display, or it cannot show pictures. what() is one sentence.
class WindowError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

struct MirrorSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};  // file; empty: none
    bool validation = false;
    render::Look look = render::Look::reveal;
    const haptics::TouchMap* touch = nullptr;  // see PictureSettings
    double tick_s = 0.001;
    bool desktop = false;                // no headset: the room is drawn by Desktop (desktop.cpp)
    training::Hints hints{};             // what the trainee is shown, and this window with it
    std::string rearm_act{};             // see PictureSettings
    std::shared_ptr<WindowPort> port{};  // receives the input of the window; null: the input is ignored
    int width = 1280, height = 720;
};

class Mirror {
  public:
    // Opens the window. All arguments must outlive it. Throws WindowError.
    Mirror(const patient::Patient&, const patient::PlannedPath&, const MirrorSettings&);
    // Waits for its thread to finish, but for a display that does not answer at most a second.
    ~Mirror();
    Mirror(const Mirror&) = delete;
    Mirror& operator=(const Mirror&) = delete;

    // For use by one frame thread.
    MirrorChannels& channels();
    // Counts so far. Any thread.
    std::uint64_t shown() const;  // pictures presented
    std::uint64_t validationMessages() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
