// The instructor's window: what the trainee sees, a free camera, the equipment screens and the numbers. It
// has a thread and a Vulkan device of its own. It may block, be minimised, closed or lost, and the headset
// never waits for it.
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
    PictureSettings pictures{};              // what the trainee is shown, and this window with it
    std::filesystem::path pipeline_cache{};  // of the window's own device; empty: none
    bool desktop = false;                    // no headset: the room is drawn by Desktop (desktop.cpp)
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
