// What eyes and ears are given while the soak runs: the room in the mock runtime's headset, the machines'
// screens, hints and alerts, sounds through OpenAL to a device that throws them away. The trainer's own
// parts, opened and closed with each attempt as the trainer does.
#pragma once

#include <memory>
#include <string>

#include "app/trainer/attempt.h"
#include "app/trainer/pictures.h"
#include "app/trainer/session.h"
#include "tests/bench/soak.h"

namespace stylet::soak {

// Before there are threads: what the headset's runtime and the sound's library are to be, in `folder`.
void prepareSenses(const std::filesystem::path& folder, const patient::Patient&, const patient::PlannedPath&);

class Senses {
  public:
    struct Of {
        const trainer::Attempt& attempt;
        const patient::PlannedPath& path;
        training::Difficulty difficulty;
        std::filesystem::path folder;  // of the attempt: pictures of its moments
        double seen_fps = 0.0;         // with a headset on; 0: without
        std::function<void(const std::string&)> say;
    };
    // The counts must outlive it.
    Senses(const Of&, Counts&);
    ~Senses();
    Senses(const Senses&) = delete;
    Senses& operator=(const Senses&) = delete;

    // After a tick; what is heard of it now and then, as the session's thread does.
    bool wants(const haptics::TickOutput& now) const { return now.tick % kHeardEvery == 0; }
    void hear(const trainer::Seen&);
    // For runFast(); it must not outlive this. `drawn` is told of each frame.
    trainer::Pictures pictures(std::function<void()> drawn);
    // Frames a virtual second.
    double fps() const;

  private:
    static constexpr std::uint64_t kHeardEvery = 10;
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::soak
