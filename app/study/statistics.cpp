#include "app/study/statistics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "base/statistics.h"

namespace stylet::study {

namespace {

constexpr double kOutlierSigmas = 2.7;
constexpr double kWhiskerBoxes = 1.5;

template <typename Value>
Spread computeSpreadOf(std::span<const PathResult> results, const Value& value) {
    std::vector<double> values;
    values.reserve(results.size());
    for (const PathResult& r : results)
        values.push_back(value(r));
    return computeSpread(std::move(values));
}

template <typename Predicate>
double shareWhere(std::span<const PathResult> results, const Predicate& is) {
    return double(std::count_if(results.begin(), results.end(), is)) / double(results.size());
}

TissueSummary summariseTissue(patient::Tissue tissue, std::span<const PathResult> results, double all_n2) {
    const auto t = std::size_t(tissue);
    TissueSummary s;
    s.tissue = tissue;
    s.mean_distance_m = computeSpreadOf(results, [&](const PathResult& r) { return r.by_tissue[t].mean_m; });
    s.hausdorff_m = computeSpreadOf(results, [&](const PathResult& r) { return r.by_tissue[t].hausdorff_m; });
    s.event_error_m = computeSpreadOf(results, [&](const PathResult& r) { return std::fabs(r.event_m[t]); });
    s.event_offset_m = computeSpreadOf(results, [&](const PathResult& r) { return r.event_m[t]; }).mean;
    double sum_n2 = 0.0;
    for (const PathResult& r : results) {
        s.missed += r.by_tissue[t].missed;
        s.invented += r.by_tissue[t].invented;
        sum_n2 += r.sum_n2[t];
    }
    s.error_share = all_n2 > 0.0 ? sum_n2 / all_n2 : 0.0;
    return s;
}

std::vector<CauseCount> countCausesAbove(std::span<const PathResult> results, double limit_n) {
    std::map<std::tuple<patient::Tissue, haptics::NeedleEventKind, Model>, std::vector<double>> found;
    for (const PathResult& r : results)
        if (r.cause.model != Model::neither && r.sampled.max_n > limit_n)
            found[{r.cause.tissue, r.cause.kind, r.cause.model}].push_back(r.cause.offset_m);
    std::vector<CauseCount> causes;
    for (const auto& [key, offset_m] : found) {
        const auto& [tissue, kind, model] = key;
        causes.push_back({{model, tissue, kind, median(offset_m)}, offset_m.size()});
    }
    std::sort(causes.begin(), causes.end(), [](const CauseCount& a, const CauseCount& b) {
        return std::tie(b.paths, a.cause.tissue, a.cause.kind, a.cause.model) <
               std::tie(a.paths, b.cause.tissue, b.cause.kind, b.cause.model);
    });
    return causes;
}

}  // namespace

Spread computeSpread(std::vector<double> values) {
    std::erase_if(values, [](double v) { return std::isnan(v); });
    Spread s;
    s.count = values.size();
    if (values.empty()) return s;
    std::sort(values.begin(), values.end());
    s.mean = mean(values);
    if (s.count > 1) s.sigma = sampleDeviation(values, s.mean);
    s.min = values.front(), s.max = values.back();
    s.lower_quartile = quantile(values, 0.25);
    s.median = median(values);
    s.upper_quartile = quantile(values, 0.75);
    const double reach = kWhiskerBoxes * (s.upper_quartile - s.lower_quartile);
    s.lower_whisker = *std::lower_bound(values.begin(), values.end(), s.lower_quartile - reach);
    s.upper_whisker = *(std::upper_bound(values.begin(), values.end(), s.upper_quartile + reach) - 1);
    s.outlier_limit = s.mean + kOutlierSigmas * s.sigma;
    const auto shareAbove = [&](double limit) {
        return double(values.end() - std::upper_bound(values.begin(), values.end(), limit)) / double(s.count);
    };
    s.outlier_share = shareAbove(s.outlier_limit);
    s.above_whisker_share = shareAbove(s.upper_whisker);
    return s;
}

Summary summarise(std::string name, std::span<const PathResult> results) {
    Summary s;
    s.name = std::move(name);
    s.paths = results.size();
    if (results.empty()) return s;
    s.rmse_n = computeSpreadOf(results, [](const PathResult& r) { return r.sampled.rmse_n; });
    s.max_n = computeSpreadOf(results, [](const PathResult& r) { return r.sampled.max_n; });
    s.equal_share = computeSpreadOf(results, [](const PathResult& r) { return r.sampled.equal_share; });
    s.max_outside_n = computeSpreadOf(results, [](const PathResult& r) { return r.max_outside_n; });
    s.exact_rmse_n = computeSpreadOf(results, [](const PathResult& r) { return r.exact.rmse_n; });
    s.exact_max_n = computeSpreadOf(results, [](const PathResult& r) { return r.exact.max_n; });
    s.exact_equal_share = computeSpreadOf(results, [](const PathResult& r) { return r.exact.equal_share; });
    s.mean_distance_m = computeSpreadOf(results, [](const PathResult& r) { return r.borders.mean_m; });
    s.hausdorff_m = computeSpreadOf(results, [](const PathResult& r) { return r.borders.hausdorff_m; });
    s.rmse_noticed_share =
        shareWhere(results, [](const PathResult& r) { return r.sampled.rmse_n > kNoticeableForce_n; });
    s.distance_noticed_share =
        shareWhere(results, [](const PathResult& r) { return r.borders.mean_m > kNoticeableDistance_m; });
    s.hausdorff_noticed_share =
        shareWhere(results, [](const PathResult& r) { return r.borders.hausdorff_m > kNoticeableOutlier_m; });
    s.same_order_share = shareWhere(results, [](const PathResult& r) { return r.same_order; });
    s.same_order_inside_share = shareWhere(results, [](const PathResult& r) { return r.same_order_inside; });
    s.same_order_noticeable_share =
        shareWhere(results, [](const PathResult& r) { return r.same_order_noticeable; });

    double all_n2 = 0.0;
    for (const PathResult& r : results) {
        s.samples += r.samples;
        s.bone_paths += r.meets_bone;
        s.missed_paths += r.borders.missed > 0;
        s.invented_paths += r.borders.invented > 0;
        for (std::size_t bin = 0; bin < kPositionBins; ++bin)
            s.position_rmse_n[bin] += r.position_n2[bin];
    }
    for (double& bin : s.position_rmse_n) {
        all_n2 += bin;
        bin = std::sqrt(bin * kPositionBins / double(s.samples));
    }
    s.pooled_rmse_n = std::sqrt(all_n2 / double(s.samples));
    for (std::size_t t = 0; t < kTissues; ++t)
        s.tissues.push_back(summariseTissue(patient::Tissue(t), results, all_n2));
    s.causes = countCausesAbove(results, 0.0);
    s.outlier_causes = countCausesAbove(results, s.max_n.outlier_limit);
    return s;
}

Cohort computeCohort(std::span<const Summary> patients) {
    std::vector<double> rmse_n, max_n, equal_share;
    for (const Summary& p : patients) {
        rmse_n.push_back(p.rmse_n.mean);
        max_n.push_back(p.max_n.mean);
        equal_share.push_back(p.equal_share.mean);
    }
    return {computeSpread(rmse_n), computeSpread(max_n), computeSpread(equal_share)};
}

}  // namespace stylet::study
