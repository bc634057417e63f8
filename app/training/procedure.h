// Follows the procedure over the ticks of an attempt: which steps are done, distances, score. Derived from
// hashed state but not hashed itself, so a change of the score table does not change an attempt.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/training/case_review.h"
#include "app/training/evidence.h"
#include "app/training/metrics.h"
#include "app/training/pain.h"
#include "app/training/safety.h"

namespace stylet::training {

class Procedure {
  public:
    // Computes the surroundings of the path once (surroundings.h). `patient` must outlive this object.
    Procedure(const patient::Patient& patient, const patient::PlannedPath&, double dt_s);
    // Tools of the attempt; without this call, the default ones.
    void setTools(const haptics::ToolSettings& tools) noexcept {
        guide_ = tools.guide;
        evidence_.setTools(tools);
    }
    // Before the first tick; without this call, kDefaultCourse.
    void setCourse(Course course) noexcept {
        progress_.course = course;
        evidence_.setCourse(course);
    }
    // Before the first tick; without this call, or without a case, there is no review.
    void setCase(std::shared_ptr<const PatientCase> patient_case) {
        progress_.has_case = patient_case != nullptr;
        review_.setCase(std::move(patient_case));
    }

    // Session thread only. Processes the next tick, which `fold` must already contain.
    void update(const haptics::TickOutput&, const AttemptFold& fold);
    // Processes an event of the newest tick. `target_cut`: it is the first puncture of the target duct.
    void update(const haptics::NeedleEvent&, const haptics::TickOutput&, bool target_cut);

    const Progress& progress() const noexcept { return progress_; }
    Score score() const noexcept {
        return computeScore(metrics_.values(), progress_.steps_done, progress_.course, progress_.has_case);
    }
    // Events since the last call, in order.
    std::vector<SessionEvent> consumeEvents() { return std::exchange(events_, {}); }

  private:
    TickFacts computeFacts(const haptics::TickOutput&) noexcept;
    CurrentPath currentPath(const patient::Surrogate&) noexcept;
    RiskStructure findCurrentRisk(const haptics::TickOutput&) const noexcept;
    bool inTarget(const haptics::TickOutput&) const noexcept;
    bool infiltrates(const haptics::TickOutput&) const noexcept;
    void updateSteps(const haptics::TickOutput&, const TickFacts&, const AttemptFold&);
    void updateSafety(const haptics::TickOutput&, const TickFacts&, const AttemptFold&);
    void updatePain(const haptics::TickOutput&, const AttemptFold&);
    void updateReview(const haptics::TickOutput&, const AttemptFold&);
    void finish(Step, std::uint64_t tick);
    void refuse(Refusal, std::uint64_t tick);
    Step firstMissing(const haptics::TickOutput&) const noexcept;
    void reportChanges(const haptics::TickOutput&);
    void addEvent(std::uint64_t tick, const char* kind, std::string text);
    void updateScore() noexcept;

    const patient::Patient* patient_;
    patient::PlannedPath path_;
    double dt_s_;
    haptics::GuideSettings guide_{};
    Surroundings surroundings_;
    Metrics metrics_;
    Evidence evidence_;
    SafetyWatch safety_;
    CaseReview review_;
    Pain pain_;
    patient::Side entry_side_, target_side_;
    patient::LocalMotion entry_motion_, target_motion_;
    Progress progress_;
    bool begun_ = false, bone_held_ = false, infiltrates_ = false;
    haptics::TickOutput previous_;
    std::uint64_t first_tick_ = 0;
    std::uint32_t early_steps_ = 0;  // bit per step that was done before an earlier one
    std::vector<SessionEvent> events_;
};

}  // namespace stylet::training
