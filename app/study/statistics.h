// Many paths' results in the numbers that a report shows: of a patient, or of all.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/study/metrics.h"

namespace stylet::study {

inline constexpr double kMm = 1e3;  // in a metre, for what is shown

// One value of each path; those that have none are left out.
struct Spread {
    std::size_t count = 0;
    double mean = kNone, sigma = kNone;  // of a sample
    double least = kNone, lower_quartile = kNone, median = kNone, upper_quartile = kNone, most = kNone;
    double lower_whisker = kNone, upper_whisker = kNone;  // the last values within 1.5 boxes of the box
    double outlier_limit = kNone;                         // mean + 2.7 sigma
    double outlier_share = 0.0;                           // of the values above it
    double above_whisker_share = 0.0;                     // of the values above the upper whisker
};
Spread spreadOf(std::vector<double> values);

struct TissueSummary {
    patient::Tissue tissue = patient::Tissue::air;
    Spread mean_distance_m, hausdorff_m;
    Spread event_error_m;                  // without its sign
    double event_offset_m = kNone;         // mean, with it: below zero where the partial patient is too early
    std::size_t missed = 0, invented = 0;  // paths
    double error_share = 0.0;  // of all squared errors, with the tip in this tissue of the full patient
};

// How many paths have their largest error after such an event.
struct CauseCount {
    Cause cause;  // `apart_m` the median of those that have one
    std::size_t paths = 0;
};

struct Summary {
    std::string name;
    std::size_t paths = 0, samples = 0;
    Spread rmse_n, max_n, equal_share, max_outside_n;
    Spread exact_rmse_n, exact_max_n, exact_equal_share;
    double pooled_rmse_n = kNone;  // over all samples
    Spread mean_distance_m, hausdorff_m;
    double rmse_noticed_share = 0.0;       // paths above kNoticedForce_n
    double distance_noticed_share = 0.0;   // above kNoticedDistance_m
    double hausdorff_noticed_share = 0.0;  // above kNoticedOutlier_m
    double same_order_share = 0.0, same_order_inside_share = 0.0;
    std::size_t bone_paths = 0;
    std::size_t missed_paths = 0, invented_paths = 0;  // with a structure that only one patient has there
    std::vector<TissueSummary> tissues;
    std::array<double, kPositionBins> position_rmse_n{};  // from the skin to the target
    std::vector<CauseCount> causes;                       // of every path with an error, most frequent first
    std::vector<CauseCount> outlier_causes;               // of the paths above max_n.outlier_limit
};
// The order of the results does not matter to anything but the last bits.
Summary summarise(std::string name, std::span<const PathResult>);

// Of the patients' own means: what an average over patients says, each with the same weight.
struct Cohort {
    Spread rmse_n, max_n, equal_share;
};
Cohort cohortOf(std::span<const Summary> patients);

}  // namespace stylet::study
