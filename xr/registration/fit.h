// Where the device stands in the room, from pairs of what the device says of its tip and what the headset
// says of a controller whose own tip is on it. Consensus first (least median of squares, P. J. Rousseeuw,
// J. Am. Stat. Assoc. 79, 1984), then all unknowns together by Gauss-Newton with weak priors, which keep
// still what the pairs cannot tell.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "xr/registration/rigid.h"

namespace stylet::xr::registration {

struct Pair {
    Rigid device_from_stylus;
    Rigid stage_from_grip;
    Vec3 tip_m_per_s{0.0};  // device frame; for the clock offset
};

struct FitSettings {
    // What is estimated besides where the device stands; what is not stays at its guess.
    bool scale = true;     // of the device's millimetres
    bool gimbal = true;    // a constant offset of the tip in the stylus frame; wants the device's orientation
    bool tip = false;      // the controller's tip in the grip frame; a vague guess wants many turned pairs
    bool latency = false;  // beyond the one by which the pairs were made; wants tip_m_per_s
    Vec3 tip_guess_m{0.0};
    // Priors' standard deviations.
    double scale_sd = 0.01, gimbal_sd_m = 0.004, tip_sd_m = 0.1, latency_sd_s = 0.05;
    // Noise expected of a pair along an axis, counted like `noise_pairs` residuals that were seen: eight
    // points alone tell little of their own noise.
    double noise_m = 0.001, noise_pairs = 2.0;
    // Pairs follow one another in time and may share an error: the residuals' own correlation counts.
    bool in_order = false;
    Cube cube;  // where the tip works: device frame
    std::uint32_t seed = 1;
};

struct Fit {
    Rigid stage_from_device;
    double scale = 1.0;
    Vec3 stylus_from_tip_m{0.0};
    Vec3 grip_from_tip_m{0.0};
    double latency_s = 0.0;
    int kept = 0, rejected = 0;
    std::vector<bool> used;    // of each pair
    double fre_m = 0.0;        // root mean square residual of what was kept
    double noise_m = 0.0;      // of a pair, along an axis
    double independent = 0.0;  // so many pairs the kept ones are worth
    CubeError tre;             // predicted
    double scale_sd = 0.0, gimbal_sd_m = 0.0, latency_sd_s = 0.0;  // left over
    Spread spread;                                                 // of the device's tips that were kept
    double turned_rad = 0.0;                                       // how far the controller was turned

    Vec3 inStage(const Rigid& device_from_stylus) const {
        return stage_from_device * (scale * (device_from_stylus * stylus_from_tip_m));
    }
};

inline constexpr int kLeastPairs = 4;
inline constexpr int kLeastPairsForTip = 12;  // where the tip is vague
inline constexpr double kVague_m = 0.02;      // the least tip_sd_m that counts as such

// Refuses too few pairs, numbers that are none, points in one place, on a line or in a plane. An earlier fit
// of about the same pairs, where there is one, takes the place of the consensus.
Answer<Fit> fitPairs(std::span<const Pair>, const FitSettings&, const Fit* earlier = nullptr);

struct Limits {
    double tre_mean_m = 0.0018;  // Wang et al., IEEE Trans. Haptics: 1.8 mm on a rig calibrated by a FARO arm
    double tre_worst_m = 0.004;
    double fre_m = 0.004;
    double scale = 0.03, gimbal_m = 0.012, rejected = 0.34;
};
struct Verdict {
    bool accept = false;
    std::string why;  // a sentence
};
Verdict judge(const Fit&, const Limits& = {});

}  // namespace stylet::xr::registration
