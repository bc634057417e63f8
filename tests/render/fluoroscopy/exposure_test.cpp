#include "render/fluoroscopy/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/fluoroscopy/tone.h"

namespace stylet::render {
namespace {

constexpr double kFarther2 = (1100.0 / 570.0) * (1100.0 / 570.0);

TEST(Exposure, HoldsTheDetectorKermaConstant) {
    const DoseSettings dose;
    const Exposure e = computeExposure(0.02, {}, 0.3, 256, 7.5, dose);
    EXPECT_FALSE(e.at_limit);
    EXPECT_NEAR(e.reference_kerma_gy, 40e-9 / 0.02 * kFarther2, 1e-15);
    EXPECT_NEAR(e.dose_area_gy_m2, 40e-9 / 0.02 * 0.09, 1e-15);
    // Quanta detected behind the patient: 40 nGy of 33,400 photons/mm2/uGy on (300/256 mm)^2, 65 % of them.
    EXPECT_NEAR(e.quanta_per_pixel * 0.02, 0.040 * 33400 * (300.0 / 256) * (300.0 / 256) * 0.65, 0.5);
}

// An abdomen of 20 cm at 7.5 pulses per second. Measured values in practice: a few mGy per minute at the
// reference point and 0.5 to 2 Gy cm2 per minute.
// HZ-TEACH-16
TEST(Exposure, MatchesTheOrderOfMeasuredDoses) {
    const Exposure e = computeExposure(std::exp(-0.0193 * 200), {}, 0.3, 256, 7.5, {});
    const double mgy_per_min = e.reference_kerma_gy * 7.5 * 60.0 * 1e3;
    const double gycm2_per_min = e.dose_area_gy_m2 * 7.5 * 60.0 * 1e4;
    EXPECT_GT(mgy_per_min, 2.0);
    EXPECT_LT(mgy_per_min, 20.0);
    EXPECT_GT(gycm2_per_min, 0.3);
    EXPECT_LT(gycm2_per_min, 3.0);
}

TEST(Exposure, DoseAreaFollowsTheCollimatorAndTheKermaDoesNot) {
    const Exposure open = computeExposure(0.02, {}, 0.3, 256, 7.5, {});
    const Exposure half = computeExposure(0.02, {.left_m = 0.075, .right_m = 0.075}, 0.3, 256, 7.5, {});
    EXPECT_DOUBLE_EQ(half.reference_kerma_gy, open.reference_kerma_gy);
    EXPECT_NEAR(half.dose_area_gy_m2, 0.5 * open.dose_area_gy_m2, 1e-18);
}

TEST(Exposure, HasLimits) {
    const DoseSettings dose;
    const Exposure thick = computeExposure(1e-6, {}, 0.3, 256, 7.5, dose);
    EXPECT_TRUE(thick.at_limit);
    EXPECT_DOUBLE_EQ(thick.reference_kerma_gy, 60e-6);
    // 88 mGy per minute at 30 pulses per second.
    EXPECT_NEAR(computeExposure(1e-6, {}, 0.3, 256, 30.0, dose).reference_kerma_gy * 30.0 * 60.0, 88e-3,
                1e-4);
    const Exposure nothing = computeExposure(1.0, {}, 0.3, 256, 7.5, dose);
    EXPECT_DOUBLE_EQ(nothing.reference_kerma_gy, 5e-6 / 7.5);
}

TEST(Exposure, MetersOnlyOpenPixelsOverThePatient) {
    EXPECT_EQ(meteredTransmission({}), 1.0);
    EXPECT_EQ(meteredTransmission(std::vector<float>{-1.0f, 0.0f, 0.01f}), 1.0);
    EXPECT_NEAR(meteredTransmission(std::vector<float>{-1.0f, 0.0f, 3.0f, 5.0f}), std::exp(-4.0), 1e-12);
}

TEST(Tone, SmoothsOnlyOpenCells) {
    std::vector<float> lattice(64 * 64, 3.0f), scratch(64 * 64);
    for (int row = 0; row < 64; ++row)
        for (int column = 0; column < 20; ++column)
            lattice[std::size_t(row * 64 + column)] = -1.0f;
    smoothOpen(lattice, 64, scratch);
    // Closed cells must not darken their neighbours.
    EXPECT_NEAR(lattice[32 * 64 + 21], 3.0f, 1e-5f);
    EXPECT_NEAR(lattice[32 * 64 + 60], 3.0f, 1e-5f);
    EXPECT_EQ(lattice[32 * 64 + 1], 0.0f);
    // A step becomes a slope, symmetric about its middle.
    for (int row = 0; row < 64; ++row)
        for (int column = 0; column < 64; ++column)
            lattice[std::size_t(row * 64 + column)] = column < 32 ? 2.0f : 4.0f;
    smoothOpen(lattice, 64, scratch);
    EXPECT_NEAR(lattice[32 * 64 + 31] + lattice[32 * 64 + 32], 6.0f, 1e-4f);
    EXPECT_GT(lattice[32 * 64 + 40], lattice[32 * 64 + 24] + 0.5f);
    EXPECT_NEAR(lattice[32 * 64 + 2], 2.0f, 1e-5f);
}

}  // namespace
}  // namespace stylet::render
