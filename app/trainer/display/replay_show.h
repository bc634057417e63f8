// Shows a replay in a headset or a window, from any viewpoint and with scrubbing. Shows the room, the
// equipment screens, slices and numbers of any tick.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "app/trainer/session/session.h"
#include "app/trainer/view/contacts.h"

namespace stylet::trainer {

// Frame states of a replay, stored every few ticks.
class Timeline {
  public:
    // `ticks`: length of the replay. Stores at most about kMaxStates states.
    explicit Timeline(std::size_t ticks);
    // Call for every tick in order. `seen` is called only for ticks that are stored.
    template <typename MakeState>
    void add(std::uint64_t tick, const MakeState& seen) {
        if (tick % every_ == 0 || seen_.empty()) seen_.push_back(seen());
    }
    // Newest state at or before `tick`. If `tick` is before the first state, returns the first state. The
    // timeline must not be empty.
    const FrameState& at(double tick) const;
    bool empty() const { return seen_.empty(); }

    static constexpr std::size_t kMaxStates = 24'000;

  private:
    std::uint64_t every_;
    std::vector<FrameState> seen_;
};

struct ShownReplay {
    const patient::Patient& patient;
    const patient::PlannedPath& path;
    const Timeline& timeline;
    const Timeline* ghost = nullptr;  // another attempt on the same patient, whose needle is also shown
    std::size_t ticks = 0;
    PressInput press{};
    bool window = false;           // use a window even if there is a headset
    std::optional<double> at_s{};  // start position; the replay is then paused
};

// Renders the capture points into `out`, and the start position as "at" if `at_s` is set. Then shows the
// replay in a headset with a window beside it, or in a window alone. Returns when the runtime or the user
// ends it. Throws EnvironmentError if there is neither a headset nor a display.
void showReplay(const ShownReplay&, const std::vector<Capture>&, const std::filesystem::path& out);

}  // namespace stylet::trainer
