// Reports on many attempts: one trainee over time, or a cohort side by side.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"
#include "app/report/page.h"

namespace stylet::report {

struct GroupReport {
    std::string html;
    Table attempts;  // for CSV: one row per attempt, with every metric
};

// The attempts of one trainee, oldest first. `cohort` contains all attempts, including the trainee's.
// `warnings`: one paragraph each (records::findAlteredRows).
GroupReport traineeReport(const std::string& trainee, const std::vector<records::StoredAttempt>& attempts,
                          const std::vector<records::StoredAttempt>& cohort,
                          const std::vector<std::string>& warnings = {});

// Attempts of any trainees, oldest first. `what` describes the selection: "scenario procedure".
GroupReport cohortReport(const std::string& what, const std::vector<records::StoredAttempt>& attempts,
                         const std::vector<std::string>& warnings = {});

// One row per attempt: trainee, date, scenario, result, and a column for each metric that occurs.
Table attemptsTable(const std::vector<records::StoredAttempt>&);

}  // namespace stylet::report
