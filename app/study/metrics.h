// Compares the partial patient's force with the full patient's along one path: size, place and cause of
// errors. Based on Mastmeyer et al. 2017, "Quantitative Measures" and Eq. 11.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "app/study/steering.h"

namespace stylet::study {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::size_t kTissues = patient::kTissueCount;
inline constexpr int kPositionBins = 20;  // along the path from the skin to the target

// Just noticeable differences for the human hand: Mastmeyer et al. 2017, "Quantitative Measures".
inline constexpr double kNoticeableForce_n = 0.145, kNoticeableDistance_m = 0.002,
                        kNoticeableOutlier_m = 0.003;

struct MeasureSettings {
    // Errors within this distance of an event of either patient are attributed to the event's position.
    double event_window_m = kNoticeableDistance_m;
};

// Force error over the path, from its start to the target.
struct ForceError {
    double rmse_n = 0.0;
    double max_n = 0.0, max_at_m = 0.0;  // the paper's "MAE", and its depth from the entry
    double equal_share = 0.0;            // share of the path where both forces are bit-identical
};

// Distances along the path between the surfaces of one structure in the full and in the partial patient. Each
// surface before the target is compared with the nearest one in the other patient.
struct BorderError {
    double mean_m = kNone, hausdorff_m = kNone;  // none if missed, invented or not on the path
    std::uint8_t missed = 0, invented = 0;       // 1: only the full / partial patient has it
};

enum class Model : std::uint8_t { full, partial, neither };

// The probable cause of the largest force error. Among the events that only one patient has, it is the one
// after which the error rose the most on its way to the maximum.
struct Cause {
    Model model = Model::neither;  // the patient that has the event
    patient::Tissue tissue = patient::Tissue::air;
    haptics::NeedleEventKind kind = haptics::NeedleEventKind::border;
    double offset_m = kNone;  // position in partial minus full, for the nearest event of the same kind
};

// Trivially copyable. Bit-identical on every machine and rank.
struct PathResult {
    ForceError sampled, exact;  // `exact`: in closed form; all none if the patients breathe
    std::uint32_t samples = 0;
    double travel_m = 0.0;           // from the first touch to the target
    double max_outside_n = 0.0;      // largest error of samples farther than the window from every event
    bool same_order = false;         // both patients have the same cuts and entries in the same order
    bool same_order_inside = false;  // the same, ignoring the skin
    // As same_order, but one patient may lack layers of soft tissue, liver or duct that are together thinner
    // than kNoticeableDistance_m, and a layer may begin up to that distance behind the target in one of them
    bool same_order_noticeable = false;
    bool meets_bone = false;  // in either patient: the needle stops there
    BorderError borders;      // over all structures; hausdorff_m is the largest of theirs
    std::array<BorderError, kTissues> by_tissue;
    std::array<double, kTissues>
        event_m{};  // depth of the first entry into each tissue, partial minus full; or none
    std::array<double, kTissues> sum_n2{};  // sum of squared errors, by tissue of the full patient
    std::array<double, kPositionBins> position_n2{};
    Cause cause;
};

PathResult measure(const SteeringResult&, const MeasureSettings& = {});

}  // namespace stylet::study
