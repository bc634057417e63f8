// The instructor's window. It shows the trainee's view, a free camera, the equipment screens and the measured
// values. The window has a thread and a Vulkan device of its own. The headset therefore never waits for it,
// even if the window blocks, is minimised, closed or lost.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "app/trainer/view/pictures.h"
#include "app/trainer/window/mirror_channels.h"
#include "base/errors.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// There is no display, or the display cannot show pictures. what() is one sentence.
class WindowError : public EnvironmentError {
  public:
    using EnvironmentError::EnvironmentError;
};

struct MirrorSettings {
    PictureSettings pictures{};              // render settings, the same as for the trainee's view
    std::filesystem::path pipeline_cache{};  // pipeline cache file of the window's Vulkan device; empty: none
    bool desktop = false;                    // run without a headset; Desktop (desktop.cpp) draws the room
    int width = 1280, height = 720;
};

class Mirror {
  public:
    // Opens the window. All arguments must outlive the Mirror. Throws WindowError.
    Mirror(const patient::Patient&, const patient::PlannedPath&, const MirrorSettings&);
    // Closes the window and waits for its thread to finish. If the display does not answer for one second,
    // abandons the thread.
    ~Mirror();
    Mirror(const Mirror&) = delete;
    Mirror& operator=(const Mirror&) = delete;

    // Channels between the window thread and the frame thread. Only one frame thread may use them.
    MirrorChannels& channels();
    // Counts so far. Any thread.
    std::uint64_t shown() const;  // pictures presented
    std::uint64_t validationMessages() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
