// The instructor's window. It shows the trainee's view, a free camera, the equipment screens and the measured
// values. The window has a thread and a Vulkan device of its own. The headset therefore never waits for it,
// even if the window blocks, is minimised, closed or lost.
#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "app/trainer/view/pictures.h"
#include "app/trainer/window/mirror_channels.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// There is no display, or it cannot show pictures. what() is one sentence.
class WindowError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
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
    // Closes the window and waits for its thread to finish. If the thread waits for a display that does not
    // answer, the destructor gives up after one second and leaves the thread behind.
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
