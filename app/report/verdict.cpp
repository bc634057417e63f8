#include "app/report/verdict.h"

#include <algorithm>

#include "app/training/score.h"

namespace stylet::report {

bool passed(const records::StoredAttempt& attempt) {
    if (!attempt.result) return false;
    const records::StepsResult& steps = attempt.result->steps;
    return attempt.result->total >= training::kPassMark &&
           std::find(steps.done.begin(), steps.done.end(), steps.goal) != steps.done.end() &&
           criticalErrors(attempt).empty();
}

std::vector<std::string> criticalErrors(const records::StoredAttempt& attempt) {
    std::vector<std::string> errors;
    for (const records::EventRow& event : attempt.events)
        if (event.kind == "critical") errors.push_back(event.text);
    return errors;
}

}  // namespace stylet::report
