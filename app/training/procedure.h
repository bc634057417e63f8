// Follows the procedure over the ticks of an attempt: which steps are done, distances, score. Derived from
// hashed state but not hashed itself, so a change of the score table does not change an attempt.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/training/metrics.h"

namespace stylet::training {

class Procedure {
  public:
    // Computes the surroundings of the path once (surroundings.h). `patient` must outlive this object.
    Procedure(const patient::Patient& patient, const patient::PlannedPath&, double dt_s);

    // Session thread only. The next tick, already processed by `fold`.
    void take(const haptics::TickOutput&, const AttemptFold& fold);
    // An event of the newest tick. `target_cut`: it is the first puncture of the target duct.
    void take(const haptics::NeedleEvent&, const haptics::TickOutput&, bool target_cut);

    const Progress& progress() const noexcept { return progress_; }
    Score score() const noexcept { return scoreOf(metrics_.values()); }
    // Events since the last call, in order.
    std::vector<SessionEvent> takeEvents() { return std::exchange(events_, {}); }

  private:
    TickFacts factsOf(const haptics::TickOutput&) noexcept;
    PathNow pathNow(const patient::Surrogate&) noexcept;
    Struck strikingOf(const haptics::TickOutput&) const noexcept;
    bool inTarget(const haptics::TickOutput&) const noexcept;
    void watchSteps(const haptics::TickOutput&, const TickFacts&, const AttemptFold&);
    bool overGap(const Vec3& reference_m) const noexcept;
    bool inPathsSpace(const Vec3& reference_m) const noexcept;
    bool showsTarget(const haptics::TickOutput&, const Vec3& target_m, const UltrasoundState&) const noexcept;
    bool opensEntry(const haptics::Incision&) const noexcept;
    void finish(Step, std::uint64_t tick);
    void tell(const haptics::TickOutput&);
    void say(std::uint64_t tick, const char* kind, std::string text);
    void rate() noexcept;

    const patient::Patient* patient_;
    patient::PlannedPath path_;
    double dt_s_;
    Surroundings surroundings_;
    Metrics metrics_;
    patient::Side entry_side_, target_side_;
    patient::LocalMotion entry_motion_, target_motion_;
    Vec3 axis_reference_{0.0, 0.0, 1.0};
    Progress progress_;
    bool begun_ = false, bone_held_ = false;
    haptics::TickOutput before_;
    std::uint64_t first_tick_ = 0, look_ticks_ = 1, pulses_ = 0;
    std::uint32_t early_ = 0;  // bit per step that was done before an earlier one
    double pressed_s_ = 0.0, shown_s_ = 0.0;
    std::vector<SessionEvent> events_;
};

}  // namespace stylet::training
