// A short run of the study in `stylet-bench --only xr.registration`. Noise is the standard deviation along
// an axis of the fit's input. Errors are those of the tip at places throughout the 80 mm cube.
#include "tests/xr/registration/study.h"

#include <gtest/gtest.h>

namespace stylet::xr::registration::study {
namespace {

#if defined(STYLET_SANITIZED) || !defined(__OPTIMIZE__)
constexpr int kTrials = 60, kMotionTrials = 4;
#else
constexpr int kTrials = 1500, kMotionTrials = 25;
#endif

TEST(Study, TheErrorMatchesTheoryWithinTenPercent) {
    for (const int points : {4, 6, 8, 12, 20})
        for (const double noise_m : {0.0002, 0.0005, 0.001, 0.002})
            for (const bool random_places : {false, true}) {
                if (random_places && points < 8) continue;  // four random places may be collinear
                const Errors e =
                    run({.points = points, .noise_m = noise_m, .random_places = random_places}, kTrials, 7);
                EXPECT_NEAR(e.rms_m, e.expected_rms_m, 0.1 * e.expected_rms_m)
                    << points << " points, " << noise_m << " m";
                EXPECT_NEAR(e.fre_m, e.expected_fre_m, 0.1 * e.expected_fre_m);
            }
}

TEST(Study, EightPointsWithMillimetreNoise) {
    const Errors e = run({.points = 8, .noise_m = 0.001}, kTrials, 1);
    EXPECT_LE(e.mean_m, 0.0008);
    EXPECT_LE(e.p999_m, 0.002);
}

TEST(Study, AllErrorSourcesCombined) {
    Case hard{.method = Method::held,
              .points = 8,
              .gimbal_m = 0.003,
              .scale_error = 0.005,
              .delay_s = 0.02,
              .outliers = 0.1};
    const Errors held = run(hard, kTrials, 1);
    EXPECT_LE(held.mean_m, 0.0018);
    EXPECT_LE(held.mean_accepted_m, held.mean_m);
    EXPECT_GE(held.accepted, 0.9);
    EXPECT_NEAR(held.rms_m, held.expected_rms_m, 0.25 * held.expected_rms_m) << "what it says of itself";
    hard.method = Method::motion;
    for (const double correlation_time_s : {0.0, 0.3}) {
        hard.correlation_time_s = correlation_time_s;
        const Errors motion = run(hard, kMotionTrials, 1);
        EXPECT_LE(motion.mean_m, correlation_time_s > 0.0 ? 0.0012 : 0.0005);
        EXPECT_EQ(motion.refused, 0);
        EXPECT_NEAR(motion.accepted, 1.0, 1e-9);
        EXPECT_LE(motion.delay_error_s, correlation_time_s > 0.0 ? 0.008 : 0.002);
        EXPECT_NEAR(motion.rms_m, motion.expected_rms_m, 0.3 * motion.expected_rms_m);
    }
}

}  // namespace
}  // namespace stylet::xr::registration::study
