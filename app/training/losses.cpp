#include "app/training/losses.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace stylet::training {

namespace {

constexpr auto kProcedure = std::size_t(MetricId::procedure);

}  // namespace

std::array<MetricLoss, kMetricCount> splitLosses(const Score& score) {
    // The score of the same values after a whole procedure.
    MetricValues whole = score.values;
    whole[kProcedure] = kMetricTable[kProcedure].best;
    const Score with_all_steps = computeScore(whole, kAllSteps, score.course, score.has_case);
    std::array<MetricLoss, kMetricCount> losses;
    for (std::size_t i = 0; i < kMetricCount; ++i)
        losses[i] = {score.max_points[i] - with_all_steps.points[i],
                     std::max(0.0, with_all_steps.points[i] - score.points[i])};
    return losses;
}

std::vector<Loss> findLosses(const Score& score) {
    const std::array<MetricLoss, kMetricCount> split = splitLosses(score);
    Loss steps{std::nullopt, 0.0, 100.0};
    std::vector<Loss> losses;
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        steps.points += split[i].by_steps;
        losses.push_back({MetricId(i), split[i].by_value, score.max_points[i]});
    }
    losses.push_back(steps);
    std::erase_if(losses, [](const Loss& loss) { return !(loss.points >= kSmallestLoss); });
    std::sort(losses.begin(), losses.end(), [](const Loss& a, const Loss& b) {
        return a.points != b.points ? a.points > b.points : a.metric < b.metric;
    });
    return losses;
}

std::string describeMissingSteps(std::size_t done, std::size_t of) {
    return fmt::format("each metric counts only for the part of the procedure that was done: {} of {} steps",
                       done, of);
}

std::string describeValue(const Metric& metric, double value) {
    if (!std::isfinite(value)) return "not achieved";
    const std::string unit = metric.unit.empty() ? "" : " " + std::string(metric.unit);
    return fmt::format("{:.4g}{} (full points {} {:g}{})", value, unit,
                       metric.best < metric.worst ? "up to" : "from", metric.best, unit);
}

std::string describeLoss(const Loss& loss, const Score& score, std::size_t steps_done, std::size_t steps) {
    const std::string lost = fmt::format("{:.1f} of {:.3g} points lost: ", loss.points, loss.of);
    if (!loss.metric) return lost + describeMissingSteps(steps_done, steps);
    const auto i = std::size_t(*loss.metric);
    return lost + std::string(kMetricTable[i].name) + ", " + describeValue(kMetricTable[i], score.values[i]);
}

}  // namespace stylet::training
