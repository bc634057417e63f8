// The score: the metrics of metric_table.h and their total. Pure functions.
//
// A metric earns its full weight at its best value, nothing at its worst, and a linear share between. All
// points are then scaled by the completed share of the procedure (metric "procedure"), and a metric earns
// nothing before the step that it belongs to is done (Metric::needs). So an idle trainee earns no points for
// harming nobody. Each part is visible, the parts add up to the total, and a metric that gets worse never
// raises the total.
#pragma once

#include <array>
#include <span>

#include "app/training/metric_table.h"

namespace stylet::training {

std::span<const Metric> metricTable() noexcept;

// In the table's order and units. NaN, or infinity in the direction of the worst value, means "not achieved"
// and scores as the worst value.
using MetricValues = std::array<double, kMetricCount>;

struct Score {
    Course course = kDefaultCourse;
    double total = 0.0;  // 0 to 100: the sum of the points
    MetricValues values{}, points{}, max_points{};
};
// `steps_done`: bit mask of 1 << Step. The weights of a longer course are scaled so that their sum is 100.
Score computeScore(const MetricValues&, std::uint32_t steps_done, Course course = kDefaultCourse) noexcept;

// An exam is passed with this total, the course's goal reached, and no critical error.
inline constexpr double kPassMark = 60.0;
constexpr bool passesExam(const Progress& progress) noexcept {
    return progress.total >= kPassMark && progress.critical_errors == 0 &&
           contains(progress.steps_done, goalOf(progress.course));
}

}  // namespace stylet::training
