// Estimates where the haptic device stands in the room. The input is a set of pairs: the tip pose reported by
// the device, and the pose of a tracked controller whose own tip touches the device's tip.
//
// Method: consensus by least median of squares (P. J. Rousseeuw, J. Am. Stat. Assoc. 79, 1984), then
// Gauss-Newton over all unknowns. Weak priors fix the unknowns that the pairs do not determine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "xr/registration/rigid.h"

namespace stylet::xr::registration {

struct Pair {
    Pose device_from_stylus;
    Pose stage_from_grip;
    Vec3 tip_m_per_s{0.0};  // device frame; needed only to estimate the latency
};

// Tip positions reported by the device, device frame.
std::vector<Vec3> deviceTips(std::span<const Pair>);

struct FitSettings {
    // What to estimate besides the device's pose. A quantity that is not estimated keeps its initial value.
    bool scale = true;   // scale of the device's positions
    bool gimbal = true;  // constant offset of the tip in the stylus frame; needs the device's orientation
    // The controller's tip in the grip frame. If it is only vaguely known, many pairs with different
    // rotations are needed.
    bool tip = false;
    // Latency between device and controller, in addition to the time offset already used to form the pairs.
    // Needs Pair::tip_m_per_s.
    bool latency = false;
    Vec3 tip_guess_m{0.0};
    // Standard deviations of the priors.
    double scale_sd = 0.01, gimbal_sd_m = 0.004, tip_sd_m = 0.1, latency_sd_s = 0.05;
    // Prior for the noise of a pair, per axis. The noise estimate combines the residuals with this prior,
    // which counts as much as `noise_pairs` pairs. With only eight pairs, the residuals alone give a poor
    // estimate.
    double noise_m = 0.001, noise_pairs = 2.0;
    // The pairs are consecutive in time, so their errors may be correlated. The fit then accounts for the
    // autocorrelation of the residuals.
    bool in_order = false;
    Cube cube;  // working volume of the tip, device frame
    std::uint32_t seed = 1;
};

struct Fit {
    Pose stage_from_device;
    double scale = 1.0;
    Vec3 stylus_from_tip_m{0.0};
    Vec3 grip_from_tip_m{0.0};
    double latency_s = 0.0;
    int inliers = 0, rejected = 0;
    std::vector<bool> used;        // for each pair: false if it was rejected
    double fre_m = 0.0;            // fiducial registration error: RMS residual of the inliers
    double noise_m = 0.0;          // estimated noise of a pair, per axis
    double effective_pairs = 0.0;  // effective number of independent pairs among the inliers
    CubeError tre;                 // predicted target registration error
    double scale_sd = 0.0, gimbal_sd_m = 0.0, latency_sd_s = 0.0;  // posterior standard deviations
    Spread spread;                                                 // of the inliers' device tip positions
    double max_rotation_rad = 0.0;  // largest rotation between two controller poses

    Vec3 inStage(const Pose& device_from_stylus) const {
        return stage_from_device * (scale * (device_from_stylus * stylus_from_tip_m));
    }
};

inline constexpr int kMinPairs = 4;
inline constexpr int kMinPairsForTip = 12;  // if the tip's position is only vaguely known
// The tip's position counts as vaguely known if FitSettings::tip_sd_m is at least this large.
inline constexpr double kVague_m = 0.02;

// Fits the device's pose to the pairs. Returns an error for too few pairs, for non-finite numbers, and if the
// points lie in one place, on a line or in a plane. `earlier` may be a fit of nearly the same pairs. It then
// serves as the initial estimate, and the consensus step is skipped.
Result<Fit> fitPairs(std::span<const Pair>, const FitSettings&, const Fit* earlier = nullptr);

struct Limits {
    // Mean target registration error. Wang et al. (IEEE Trans. Haptics) report 1.8 mm for a setup that they
    // calibrated with a FARO measuring arm.
    double tre_mean_m = 0.0018;
    double tre_worst_m = 0.004;
    double fre_m = 0.004;
    double scale = 0.03, gimbal_m = 0.012, rejected = 0.34;
};
struct Verdict {
    bool accept = false;
    std::string why;  // one sentence for the user
};
Verdict evaluateFit(const Fit&, const Limits& = {});

}  // namespace stylet::xr::registration
