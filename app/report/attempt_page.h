// The debrief of one attempt.
#pragma once

#include <optional>
#include <vector>

#include "app/report/attempt_figures.h"
#include "app/report/stills.h"

namespace stylet::report {

// What stands beside the attempt, as far as it is there.
struct AttemptContext {
    std::vector<records::StoredAttempt> cohort{};  // all that the attempt is compared with, itself included
    const patient::Patient* patient = nullptr;     // on whom it was made: for reference curve and slices
    std::vector<ReferenceCurve> references{};      // besides that of the planned path
    std::size_t most_stills = 16;
};

struct AttemptReport {
    std::string html;
    Table metrics, events, course;  // for CSV
};

AttemptReport attemptReport(const AttemptFiles&, const AttemptContext&);

// Of the attempts that are done: each metric's values, points, and where this one stands among them.
Table metricTable(const records::AttemptResult&, const std::vector<records::StoredAttempt>& cohort);

// "2026-11-21 20:15 UTC", or the text itself.
std::string dateText(const std::string& utc);
// A value of a metric with digits to suit it.
std::string metricText(double value);

}  // namespace stylet::report
