#include "app/training/score.h"

#include <algorithm>
#include <cmath>

namespace stylet::training {

namespace {

// 1 at the best value and beyond, 0 at the worst value and beyond, 0 for NaN.
double credit(const Metric& m, double value) noexcept {
    if (std::isnan(value)) return 0.0;
    const double low = std::min(m.best, m.worst), high = std::max(m.best, m.worst);
    return (std::clamp(value, low, high) - m.worst) / (m.best - m.worst);
}

}  // namespace

std::span<const Metric> metricTable() noexcept {
    return kMetricTable;
}

std::vector<std::string_view> missingParts(Course course, std::uint32_t steps_done) {
    std::vector<std::string_view> names;
    for (const ExamPart& part : kExamParts)
        if (isMissing(part, course, steps_done)) names.push_back(part.name);
    return names;
}

Score computeScore(const MetricValues& values, std::uint32_t steps_done, Course course,
                   bool has_case) noexcept {
    const auto isScored = [&](const Metric& m) {
        return isMetricOf(course, m) && (has_case || &m != &kMetricTable[std::size_t(MetricId::caseReview)]);
    };
    double weights = 0.0;
    for (const Metric& m : kMetricTable)
        if (isScored(m)) weights += m.weight;
    Score score;
    score.course = course;
    score.has_case = has_case;
    score.values = values;
    const double scale = 100.0 / weights;
    const double done =
        credit(kMetricTable[std::size_t(MetricId::procedure)], values[std::size_t(MetricId::procedure)]);
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        const Metric& m = kMetricTable[i];
        score.max_points[i] = isScored(m) ? m.weight * scale : 0.0;
        const bool counts = m.needs == Step::done || (steps_done & 1u << unsigned(m.needs)) != 0;
        score.points[i] = counts ? score.max_points[i] * credit(m, values[i]) * done : 0.0;
        score.total += score.points[i];
    }
    return score;
}

}  // namespace stylet::training
