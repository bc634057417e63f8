// Why an attempt lost points, for console and report. Pure functions of its score.
//
// A metric loses points for two reasons: by its own value, and because all points count only for the part of
// the procedure that was done, and some only if their step was done (score.h). The second reason is one loss.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/training/score.h"

namespace stylet::training {

struct MetricLoss {
    double by_value = 0.0, by_steps = 0.0;  // points
};
// One per metric, in the table's order. The metric "procedure" loses only by steps.
std::array<MetricLoss, kMetricCount> splitLosses(const Score&);

struct Loss {
    std::optional<MetricId> metric;  // none: of all metrics, because steps were not done
    double points = 0.0;             // lost
    double of = 0.0;                 // could have been earned
};
inline constexpr double kSmallestLoss = 0.5;  // points; smaller losses are not listed
// Largest first.
std::vector<Loss> findLosses(const Score&);

// "each metric counts only for the part of the procedure that was done: 1 of 6 steps"
std::string describeMissingSteps(std::size_t done, std::size_t of);
// "22 (full points up to 5)", or "not achieved". With the metric's unit.
std::string describeValue(const Metric&, double value);
// "8.1 of 9 points lost: Skin contacts, 22 (full points up to 5)"
std::string describeLoss(const Loss&, const Score&, std::size_t steps_done, std::size_t steps);

}  // namespace stylet::training
