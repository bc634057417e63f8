// Whether a stored attempt would pass as an exam, from its result and its events.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"
#include "app/training/progress.h"

namespace stylet::report {

// A result does not name its course, so courseFromGoal() infers it. stepsDone() is a bit mask of
// 1 << training::Step.
training::Course courseFromGoal(const records::AttemptResult&);
std::uint32_t stepsDone(const records::AttemptResult&);
// The same rule as training::passesExam(); for an attempt scored before training::kExamPartsVersion, the rule
// of its time, which asked of all parts for the course's goal alone.
bool passed(const records::StoredAttempt&);
// "local anaesthesia": what an exam needs and this attempt lacks.
std::vector<std::string> missingParts(const records::AttemptResult&);
// "the gallbladder was punctured", in the order of their ticks.
std::vector<std::string> criticalErrors(const records::StoredAttempt&);

}  // namespace stylet::report
