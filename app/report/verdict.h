// Whether a stored attempt would pass as an exam, from its result and its events.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::report {

// At least training::kPassMark points, the goal of the course reached, no critical error: the same rule as
// training::passesExam().
bool passed(const records::StoredAttempt&);
// "the gallbladder was punctured", in the order of their ticks.
std::vector<std::string> criticalErrors(const records::StoredAttempt&);

}  // namespace stylet::report
