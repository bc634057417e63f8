// Summary statistics over many paths' results, for one patient or for all.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/study/metrics.h"

namespace stylet::study {

inline constexpr double kMm = 1e3;  // millimetres per metre, for display

// Distribution of one value per path. Paths without a value are left out.
struct Spread {
    std::size_t count = 0;
    double mean = kNone;
    double sigma = kNone;  // sample standard deviation; undefined for a single value
    double min = kNone, lower_quartile = kNone, median = kNone, upper_quartile = kNone, max = kNone;
    double lower_whisker = kNone, upper_whisker = kNone;  // the last values within 1.5 box lengths of the box
    double outlier_limit = kNone;                         // mean + 2.7 sigma
    double outlier_share = 0.0;                           // share of the values above outlier_limit
    double above_whisker_share = 0.0;                     // share of the values above the upper whisker
};
Spread computeSpread(std::vector<double> values);

struct TissueSummary {
    patient::Tissue tissue = patient::Tissue::air;
    Spread mean_distance_m, hausdorff_m;
    Spread event_error_m;                  // absolute value
    double event_offset_m = kNone;         // signed mean; negative: too early in the partial patient
    std::size_t missed = 0, invented = 0;  // number of paths
    double error_share = 0.0;  // share of the sum of squared errors, by the full patient's tissue at the tip
};

// Number of paths whose largest error follows this kind of event.
struct CauseCount {
    Cause cause;  // `offset_m`: median over the paths that have one
    std::size_t paths = 0;
};

struct Summary {
    std::string name;
    std::size_t paths = 0, samples = 0;
    Spread rmse_n, max_n, equal_share, max_outside_n;
    Spread exact_rmse_n, exact_max_n, exact_equal_share;
    double pooled_rmse_n = kNone;  // over all samples of all paths
    Spread mean_distance_m, hausdorff_m;
    double rmse_noticed_share = 0.0;       // paths above kNoticeableForce_n
    double distance_noticed_share = 0.0;   // above kNoticeableDistance_m
    double hausdorff_noticed_share = 0.0;  // above kNoticeableOutlier_m
    double same_order_share = 0.0, same_order_inside_share = 0.0, same_order_noticeable_share = 0.0;
    std::size_t bone_paths = 0;
    std::size_t missed_paths = 0, invented_paths = 0;  // paths with a structure that only one patient has
    std::vector<TissueSummary> tissues;
    std::array<double, kPositionBins> position_rmse_n{};  // by position from the skin to the target
    std::vector<CauseCount> causes;                       // of all paths with an error, most frequent first
    std::vector<CauseCount> outlier_causes;               // of the paths above max_n.outlier_limit
};
// The order of the results affects only the last bits.
Summary summarise(std::string name, std::span<const PathResult>);

// Statistics over the patients' means: each patient has the same weight.
struct Cohort {
    Spread rmse_n, max_n, equal_share;
};
Cohort computeCohort(std::span<const Summary> patients);

}  // namespace stylet::study
