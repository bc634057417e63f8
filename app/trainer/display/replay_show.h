// Shows a replay in a headset or a window: the room, the equipment screens, slices and numbers of any tick,
// from any viewpoint, with scrubbing.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "app/trainer/session/session.h"

namespace stylet::trainer {

// Frame states of a replay, stored every few ticks.
class Timeline {
  public:
    // `ticks`: length of the replay. At most about kMost states are stored.
    explicit Timeline(std::size_t ticks);
    // Call for every tick in order. `seen` is evaluated only for ticks that are stored.
    template <typename MakeSeen>
    void take(std::uint64_t tick, const MakeSeen& seen) {
        if (tick % every_ == 0 || seen_.empty()) seen_.push_back(seen());
    }
    // Newest state at or before `tick`, or the first one if `tick` is earlier. Must not be empty.
    const Seen& at(double tick) const;
    bool empty() const { return seen_.empty(); }

    static constexpr std::size_t kMost = 24'000;

  private:
    std::uint64_t every_;
    std::vector<Seen> seen_;
};

struct ShownReplay {
    const patient::Patient& patient;
    const patient::PlannedPath& path;
    const Timeline& timeline;
    const Timeline* ghost = nullptr;  // of another attempt on the same patient; its needle is also shown
    double dt_s = 0.001;
    std::size_t ticks = 0;
    const haptics::TouchMap* touch = nullptr;
    haptics::GuideSettings guide{};
    bool window = false;           // even if there is a headset
    std::optional<double> at_s{};  // start there, paused
};

// Renders the capture points into `out`, and the start position as "at" if `at_s` is set. Then shows the
// replay in a headset with a window beside it, or in a window alone, until the runtime or the window ends
// it. Throws DataError if neither is available.
void showReplay(const ShownReplay&, const std::vector<Moment>&, const std::filesystem::path& out);

}  // namespace stylet::trainer
