// The instructor's window: what the trainee sees, a free camera, the machines' screens and the numbers. A
// thread and a Vulkan device of its own: it may block, be minimised, closed or lost, and no headset waits.
#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "app/trainer/window/mirror_channels.h"
#include "app/trainer/window_port.h"
#include "app/training/difficulty.h"
#include "patient/planning.h"

namespace stylet::trainer {

// No display, or none that shows pictures: one sentence.
class WindowError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

struct MirrorSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};  // file; empty: none
    bool validation = false;
    render::Look look = render::Look::reveal;
    const haptics::TouchMap* touch = nullptr;  // as in PictureSettings
    double tick_s = 0.001;
    bool desktop = false;                // no headset: the pictures of the room come from Desktop
    training::Hints hints{};             // what the trainee is shown, and a window in its place with him
    std::string rearm_act{};             // as in PictureSettings
    std::shared_ptr<WindowPort> port{};  // of what is said and done in it; null: nobody listens
    int width = 1280, height = 720;
};

class Mirror {
  public:
    // Opens the window; all must outlive it. Throws WindowError.
    Mirror(const patient::Patient&, const patient::PlannedPath&, const MirrorSettings&);
    // Waits for work of its own; for a display that does not answer no longer than a second.
    ~Mirror();
    Mirror(const Mirror&) = delete;
    Mirror& operator=(const Mirror&) = delete;

    // For one frame thread.
    MirrorChannels& channels();
    // So far. Any thread.
    std::uint64_t shown() const;  // pictures of the window
    std::uint64_t validationMessages() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
