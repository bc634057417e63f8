// The review of a drainage's case: which questions are answered, how many wrongly, and which answers endanger
// the patient. Derived from the ticks, one after another.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "app/training/attempt_fold.h"
#include "app/training/patient_case.h"
#include "app/training/progress.h"

namespace stylet::training {

class CaseReview {
  public:
    // Without a case there is nothing to review.
    void setCase(std::shared_ptr<const PatientCase> patient_case) { case_ = std::move(patient_case); }
    const PatientCase* patientCase() const noexcept { return case_.get(); }

    // Session thread. Processes the next tick; no allocation. The first cut or puncture ends the review:
    // questions that are open then count as answered wrongly.
    void update(const haptics::TickOutput&, const Answers&) noexcept;
    // The next answer that has not been reported yet, in the order of the questions.
    std::optional<Question> popAnswered() noexcept;
    bool answer(Question question) const noexcept { return (yes_ & 1u << unsigned(question)) != 0; }

    int answered() const noexcept { return answered_; }
    bool isOver() const noexcept { return opened_; }  // no question is asked any more
    bool isDone() const noexcept { return case_ && answered_ == kQuestionCount; }
    // Wrong answers and, until the review is done, open questions.
    int wrong() const noexcept { return case_ ? wrong_ + kQuestionCount - answered_ : 0; }
    std::uint32_t errors() const noexcept { return errors_; }  // bit mask, 1 << CriticalError

  private:
    std::shared_ptr<const PatientCase> case_;
    int answered_ = 0, reported_ = 0, wrong_ = 0;
    std::uint32_t yes_ = 0, errors_ = 0;
    bool opened_ = false;
};

}  // namespace stylet::training
