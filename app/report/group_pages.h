// What many attempts say: of one trainee over time, and of a cohort side by side.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"
#include "app/report/page.h"

namespace stylet::report {

struct GroupReport {
    std::string html;
    Table attempts;  // for CSV: one row an attempt, with every metric
};

// The attempts of one trainee, oldest first; `cohort` holds all attempts, his included.
GroupReport traineeReport(const std::string& trainee, const std::vector<records::StoredAttempt>& attempts,
                          const std::vector<records::StoredAttempt>& cohort);

// Attempts of any trainees, oldest first. `what` says which: "scenario procedure".
GroupReport cohortReport(const std::string& what, const std::vector<records::StoredAttempt>& attempts);

// One row an attempt: who, when, what, result, and a column for each metric that any of them has.
Table attemptsTable(const std::vector<records::StoredAttempt>&);

}  // namespace stylet::report
