// How far the partial patient's force is from the full one's along one path, where, and why.
// Based on Mastmeyer et al. 2017, "Quantitative Measures" and Eq. 11.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "app/study/steering.h"

namespace stylet::study {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::size_t kTissues = patient::kTissueCount;
inline constexpr int kPositionBins = 20;  // of a path's way from the skin to the target

// What a hand notices at the least: Mastmeyer et al. 2017, "Quantitative Measures".
inline constexpr double kNoticedForce_n = 0.145, kNoticedDistance_m = 0.002, kNoticedOutlier_m = 0.003;

struct MeasureSettings {
    // Errors this near to an event of either patient are put down to its place.
    double event_window_m = kNoticedDistance_m;
};

// Over the path from its begin to the target.
struct ForceError {
    double rmse_n = 0.0;
    double max_n = 0.0, max_at_m = 0.0;  // the paper's "MAE"; from the entry
    double equal_share = 0.0;            // to the last bit
};

// Between the surfaces of one structure along the path, the full patient's and the partial one's: each that
// is met before the target against the other's nearest.
struct BorderError {
    double mean_m = kNone, hausdorff_m = kNone;  // none where it is missed or invented, or not on the way
    std::uint8_t missed = 0, invented = 0;       // the partial patient has none, or one too many
};

enum class Model : std::uint8_t { full, partial, neither };

// The event that the other patient does not have there and after which the error rose the most, on its way to
// the largest.
struct Cause {
    Model model = Model::neither;  // whose event it is
    patient::Tissue tissue = patient::Tissue::air;
    haptics::NeedleEventKind kind = haptics::NeedleEventKind::border;
    double apart_m = kNone;  // the partial patient's less the full one's, of the nearest alike
};

// Trivially copyable, and the same wherever it was worked out.
struct PathResult {
    ForceError sampled, exact;  // `exact` in closed form; all none while the patients breathe
    std::uint32_t samples = 0;
    double way_m = 0.0;              // from the first touch to the target
    double max_outside_n = 0.0;      // of the samples farther than the window from every event
    bool same_order = false;         // the same cuts and entries in the same order
    bool same_order_inside = false;  // the same, as if neither patient had a skin
    bool meets_bone = false;         // in the one patient or the other: the needle goes no farther
    BorderError borders;             // of all structures; a Hausdorff distance is the largest of theirs
    std::array<BorderError, kTissues> by_tissue;
    std::array<double, kTissues>
        event_m{};  // depth of the first way into a tissue, partial less full; or none
    std::array<double, kTissues> sum_n2{};  // of the samples' errors, by what the full patient has there
    std::array<double, kPositionBins> position_n2{};
    Cause cause;
};

PathResult measure(const Steered&, const MeasureSettings& = {});

}  // namespace stylet::study
