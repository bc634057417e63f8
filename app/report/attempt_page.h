// The debrief of one attempt.
#pragma once

#include <optional>
#include <vector>

#include "app/report/attempt_figures.h"
#include "app/report/stills.h"

namespace stylet::report {

// Optional data shown with the attempt.
struct AttemptContext {
    std::vector<records::StoredAttempt> cohort{};  // attempts to compare with, including this one
    const patient::Patient* patient = nullptr;     // the attempt's patient: for reference curve and slices
    std::vector<ReferenceCurve> references{};      // in addition to the planned path's
    std::size_t max_stills = 16;
};

struct AttemptReport {
    std::string html;
    Table metrics, events, course;  // for CSV
};

AttemptReport attemptReport(const LoadedAttempt&, const AttemptContext&);

// A row per metric: value, points, why points were lost, and this attempt's rank among the attempts of the
// cohort that count (records::countsInStatistics).
Table metricTable(const records::AttemptResult&, const std::vector<records::StoredAttempt>& cohort);

// "2026-11-21 20:15 UTC", or `utc` itself if it cannot be parsed.
std::string dateText(const std::string& utc);
// Name of a metric on a page. Metric and event of a near miss count differently, so they get different names.
std::string metricName(const records::MetricRow&);
// Formats a metric's value with a suitable number of digits.
std::string metricText(double value);

}  // namespace stylet::report
