// Output to eyes and ears during the soak: the room in the mock runtime's headset, the screens of the
// equipment, hints and alerts, sounds through OpenAL to a device that discards them. Uses the trainer's own
// parts, opened and closed with each attempt as the trainer does.
#pragma once

#include <memory>
#include <string>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/session/session.h"
#include "app/trainer/view/pictures.h"
#include "tests/bench/soak/soak.h"

namespace stylet::soak {

// Configures the headset's runtime and the sound library with files in `folder`. Call before any thread
// starts.
void prepareUserOutput(const std::filesystem::path& folder, const patient::Patient&,
                       const patient::PlannedPath&);

// Keeps the Vulkan driver loaded until the process ends. Mesa's lavapipe does not free its memory for
// executable code when it is unloaded: 10 MB of addresses, 0.07 MB of them resident, per headset.
void keepDriverLoaded();

class UserOutput {
  public:
    struct Context {
        const trainer::Attempt& attempt;
        const patient::PlannedPath& path;
        training::Difficulty difficulty;
        std::filesystem::path folder;  // the attempt's folder, for captured pictures
        double headset_fps = 0.0;      // frame rate with a headset; 0: no headset
        std::function<void(const std::string&)> log;
    };
    // The counts must outlive it.
    UserOutput(const Context&, Counts&);
    ~UserOutput();
    UserOutput(const UserOutput&) = delete;
    UserOutput& operator=(const UserOutput&) = delete;

    // Called after each tick. Returns true if playSounds() is due: every kSoundInterval_ticks ticks, as on
    // the session's thread.
    bool wants(const haptics::TickOutput& now) const { return now.tick % kSoundInterval_ticks == 0; }
    void playSounds(const trainer::FrameState&);
    // For runFast(); must not outlive this object. Calls `drawn` after each frame.
    std::unique_ptr<trainer::Display> display(std::function<void()> drawn);
    // Frames per virtual second.
    double fps() const;

  private:
    static constexpr std::uint64_t kSoundInterval_ticks = 10;
    struct Impl;
    class SoakDisplay;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::soak
