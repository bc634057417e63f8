#include "render/frame/governor.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace stylet::render {
namespace {

// A simulated machine that needs `volume_ms` at full resolution and `other_ms` for everything else.
struct SimulatedGpu {
    double volume_ms = 10.0, other_ms = 2.0, noise = 0.05;
    std::mt19937 random{7};

    double frame(Governor& governor) {
        std::uniform_real_distribution<double> around(1.0 - noise, 1.0 + noise);
        const double scale = double(governor.layerScale());
        const double volume = volume_ms * scale * scale * around(random), rest = other_ms * around(random);
        governor.reportFrame(volume, rest, scale);
        return volume + rest;
    }
};

TEST(Governor, KeepsFullResolutionOnAFastGpu) {
    Governor governor({.budget_ms = 11.1});
    SimulatedGpu gpu{.volume_ms = 4.0};
    for (int i = 0; i < 500; ++i)
        EXPECT_LT(gpu.frame(governor), 11.1);
    EXPECT_EQ(governor.layerScale(), 1.0f);
}

// HZ-USER-02
TEST(Governor, MeetsTheBudgetOfASlowGpuWithinFourFrames) {
    Governor governor({.budget_ms = 11.1});
    SimulatedGpu gpu{.volume_ms = 30.0};
    for (int i = 0; i < 4; ++i)
        gpu.frame(governor);
    int late = 0, changes = 0;
    for (int i = 0; i < 2000; ++i) {
        const float before = governor.layerScale();
        late += gpu.frame(governor) > 11.1 ? 1 : 0;
        changes += governor.layerScale() != before ? 1 : 0;
    }
    EXPECT_EQ(late, 0);
    EXPECT_LE(changes, 2) << "the picture would shimmer";
    // At most one step coarser than the budget requires.
    EXPECT_GT(governor.layerScale(), std::sqrt((0.85 * 11.1 - 2.0) / 30.0) - 0.13);
}

TEST(Governor, RaisesResolutionWithHeadroomAndIgnoresOneLateFrame) {
    Governor governor({.budget_ms = 11.1});
    SimulatedGpu gpu{.volume_ms = 30.0};
    for (int i = 0; i < 10; ++i)
        gpu.frame(governor);
    const float low = governor.layerScale();
    gpu.volume_ms = 5.0;
    for (int i = 0; i < 600; ++i)
        gpu.frame(governor);
    EXPECT_LT(low, 0.6f);
    EXPECT_EQ(governor.layerScale(), 1.0f);
    governor.reportFrame(80.0, 2.0, 1.0);
    EXPECT_EQ(governor.layerScale(), 1.0f);
}

TEST(Governor, NeverGoesBelowTheMinimumScale) {
    Governor governor({.budget_ms = 11.1, .min_scale = 0.35f});
    SimulatedGpu gpu{.volume_ms = 900.0, .other_ms = 4.0};
    for (int i = 0; i < 50; ++i)
        gpu.frame(governor);
    EXPECT_EQ(governor.layerScale(), 0.35f);
}

TEST(Governor, KeepsResolutionWhenOtherWorkExceedsTheBudget) {
    Governor governor({.budget_ms = 11.1});
    for (int i = 0; i < 50; ++i)
        governor.reportFrame(30.0, 500.0, 1.0);  // a look is being classified, or the system stalls
    EXPECT_EQ(governor.layerScale(), 1.0f);
}

TEST(Governor, LowersResolutionFromTheDrawnScale) {
    Governor governor({.budget_ms = 11.1});
    for (int i = 0; i < 4; ++i)
        governor.reportFrame(14.8, 2.0, 0.5);  // already drawn at half the scale
    EXPECT_NEAR(governor.layerScale(), 0.5 * std::sqrt((0.85 * 11.1 - 2.0) / 14.8), 0.0625);
}

TEST(Governor, IgnoresInvalidTimes) {
    Governor governor;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < 10; ++i) {
        governor.reportFrame(nan, 1.0, 1.0);
        governor.reportFrame(50.0, nan, 1.0);
        governor.reportFrame(50.0, 1.0, nan);
        governor.reportFrame(-1.0, 90.0, 1.0);
        governor.reportFrame(std::numeric_limits<double>::infinity(), 0.0, 1.0);
    }
    EXPECT_EQ(governor.layerScale(), 1.0f);
}

}  // namespace
}  // namespace stylet::render
