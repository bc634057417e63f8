#include "app/report/verdict.h"

#include <algorithm>

#include "app/training/score.h"

namespace stylet::report {

training::Course courseFromGoal(const records::AttemptResult& result) {
    return result.steps.goal == training::stepName(training::goalOf(training::Course::drainage))
               ? training::Course::drainage
               : training::Course::puncture;
}

std::uint32_t stepsDone(const records::AttemptResult& result) {
    std::uint32_t done = 0;
    for (int step = 0; step < training::kStepCount; ++step)
        if (std::ranges::find(result.steps.done, training::stepName(training::Step(step))) !=
            result.steps.done.end())
            done |= 1u << step;
    return done;
}

bool passed(const records::StoredAttempt& attempt) {
    if (!attempt.result) return false;
    return attempt.result->total >= training::kPassMark && missingParts(*attempt.result).empty() &&
           criticalErrors(attempt).empty();
}

std::vector<std::string> missingParts(const records::AttemptResult& result) {
    const training::Course course = courseFromGoal(result);
    const std::uint32_t done = stepsDone(result);
    if (result.score_version < std::uint64_t(training::kExamPartsVersion)) {
        const training::Step goal = training::goalOf(course);
        if (training::contains(done, goal)) return {};
        return {std::string(training::stepName(goal))};
    }
    const std::vector<std::string_view> names = training::missingParts(course, done);
    return {names.begin(), names.end()};
}

std::vector<std::string> criticalErrors(const records::StoredAttempt& attempt) {
    std::vector<std::string> errors;
    for (const records::EventRow& event : attempt.events)
        if (event.kind == "critical") errors.push_back(event.text);
    return errors;
}

}  // namespace stylet::report
