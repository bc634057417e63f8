// Attempts on disk and parts of pages, for the tests of the debrief.
#pragma once

#include <string>

#include "app/report/attempt_files.h"
#include "app/training/score.h"
#include "tests/app/report/attempt_folder.h"
#include "tests/support/temp_folder.h"

namespace stylet::test {

inline bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

// The part of the page from `begin` to `end`. Empty if it has no `begin`.
inline std::string textFrom(const std::string& html, const std::string& begin, const std::string& end) {
    const std::size_t from = html.find(begin), to = html.find(end, from);
    return from == html.npos ? "" : html.substr(from, to - from);
}

inline report::LoadedAttempt makeLoadedAttempt(const TempFolder& folder, std::uint64_t ticks) {
    writeAttemptFolder(folder.path(), ticks);
    return report::loadAttempt(folder.path());
}

// An attempt that did one of six steps and touched nothing, with today's metric table.
inline records::AttemptResult oneStepResult() {
    using namespace training;
    MetricValues values;
    for (std::size_t i = 0; i < kMetricCount; ++i)
        values[i] = metricTable()[i].best;
    values[std::size_t(MetricId::procedure)] = 10.0;
    values[std::size_t(MetricId::skinContacts)] = 12.0;
    values[std::size_t(MetricId::peakForce)] = 14.0;
    values[std::size_t(MetricId::nearMisses)] = 3.0;
    const Score score = computeScore(values, 1u << unsigned(Step::findGap));
    records::AttemptResult result;
    result.total = score.total, result.ticks = 20000;
    result.score_version = std::uint64_t(kScoreVersion);
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        const Metric& m = metricTable()[i];
        if (!isMetricOf(score.course, m)) continue;
        result.metrics.push_back({std::string(m.id), std::string(m.name), std::string(m.unit), values[i],
                                  score.points[i], score.max_points[i]});
    }
    result.steps = {"advance to the duct", {"find the space between the ribs"}, 6, 0};
    return result;
}

inline report::LoadedAttempt makeOneStepAttempt(const TempFolder& folder, bool aborted = false) {
    records::StoredAttempt attempt = makeTestAttempt("t1", "trainee-A", 0.0, false);
    attempt.result = oneStepResult();
    attempt.result->aborted = aborted;
    writeAttemptFolder(folder.path(), 20000, attempt);
    return report::loadAttempt(folder.path());
}

}  // namespace stylet::test
