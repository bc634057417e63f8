#include "app/report/verdict.h"

#include <algorithm>

#include "app/training/score.h"

namespace stylet::report {

bool passed(const records::StoredAttempt& attempt) {
    const auto punctured = [](const records::EventRow& event) {
        return event.kind == "step" && event.text.starts_with(training::stepName(training::Step::advance));
    };
    return attempt.result && attempt.result->total >= training::kPassMark &&
           std::any_of(attempt.events.begin(), attempt.events.end(), punctured) &&
           criticalErrors(attempt).empty();
}

std::vector<std::string> criticalErrors(const records::StoredAttempt& attempt) {
    std::vector<std::string> errors;
    for (const records::EventRow& event : attempt.events)
        if (event.kind == "critical") errors.push_back(event.text);
    return errors;
}

}  // namespace stylet::report
