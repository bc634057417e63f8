// A replay to look at: the room, the machines' screens, the slices and the numbers of every tick, in a
// headset or in the window, scrubbed and from any side.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "app/trainer/session.h"

namespace stylet::trainer {

// What there is to be seen, every so many ticks.
class Timeline {
  public:
    // Of so many ticks: what it keeps is bounded.
    explicit Timeline(std::size_t ticks);
    // Each tick in order; `seen` is asked for only where it is kept.
    template <typename MakeSeen>
    void take(std::uint64_t tick, const MakeSeen& seen) {
        if (tick % every_ == 0 || seen_.empty()) seen_.push_back(seen());
    }
    // The newest kept at `tick`; the first before it. Not empty.
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
    const Timeline* ghost = nullptr;  // of another attempt on the same patient: its needle is shown too
    double dt_s = 0.001;
    std::size_t ticks = 0;
    const haptics::TouchMap* touch = nullptr;
    haptics::GuideSettings guide{};
    bool window = false;           // though there is a headset
    std::optional<double> at_s{};  // it stands there at first
};

// Draws the moments into `out`, and as "at" where it stands at first; then shows the replay, in a headset and
// the window beside it or in the window alone, until the runtime or the window ends it. Throws
// patient::DataError where there is neither.
void showReplay(const ShownReplay&, const std::vector<Moment>&, const std::filesystem::path& out);

}  // namespace stylet::trainer
