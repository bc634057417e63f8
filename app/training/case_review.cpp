#include "app/training/case_review.h"

#include <algorithm>

namespace stylet::training {

void CaseReview::update(const haptics::TickOutput& now, const Answers& answers) noexcept {
    if (!case_ || opened_) return;
    const int given = int(std::min(answers.count, std::uint32_t(kQuestionCount)));
    for (; answered_ < given; ++answered_) {
        const auto question = Question(answered_);
        const std::uint32_t bit = 1u << unsigned(question);
        yes_ |= answers.yes & bit;
        const bool yes = (yes_ & bit) != 0;
        wrong_ += yes != rightAnswer(*case_, question);
        if (isUnsafe(*case_, question, yes)) errors_ |= 1u << unsigned(CriticalError::unfit);
    }
    if (2 * wrong_ > kQuestionCount) errors_ |= 1u << unsigned(CriticalError::unreviewed);
    opened_ = now.phase != haptics::Phase::outside || now.cut_incision >= 0;
    if (opened_ && !isDone()) errors_ |= 1u << unsigned(CriticalError::unreviewed);
}

std::optional<Question> CaseReview::popAnswered() noexcept {
    if (reported_ == answered_) return std::nullopt;
    return Question(reported_++);
}

}  // namespace stylet::training
