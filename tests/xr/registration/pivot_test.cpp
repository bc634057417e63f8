#include "xr/registration/pivot.h"

#include <gtest/gtest.h>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Random;

const Vec3 kTip{0.01, -0.03, -0.11}, kPivot{0.2, 1.0, -0.4};

std::vector<Pose> turnedAbout(Random& random, int count, double max_rad, double noise_m) {
    std::vector<Pose> poses;
    for (int i = 0; i < count; ++i) {
        const Quat turn = random.turn(max_rad);
        poses.push_back({turn, kPivot - turn * kTip + noise_m * random.normal3()});
    }
    return poses;
}

TEST(Pivot, TheTipIsFoundExactlyWithoutNoise) {
    Random random(1);
    const auto pivot = calibratePivot(turnedAbout(random, 40, 0.7, 0.0));
    ASSERT_TRUE(pivot) << pivot.why_not;
    EXPECT_LT(glm::distance(pivot->grip_from_tip_m, kTip), 1e-12);
    EXPECT_LT(glm::distance(pivot->stage_from_pivot_m, kPivot), 1e-12);
    EXPECT_GT(pivot->max_rotation_rad, 0.7);
}

// With noise, the error matches the calibration's own estimate. Tracker jumps have no effect.
TEST(Pivot, TheUncertaintyMatchesTheError) {
    double squares = 0.0, said = 0.0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial) {
        Random random(std::uint64_t(trial) + 1);
        std::vector<Pose> poses = turnedAbout(random, 100, 0.6, 0.001);
        for (std::size_t i = 0; i < poses.size(); i += 10)
            poses[i].position_m += 0.04 * random.direction();
        const auto pivot = calibratePivot(poses);
        ASSERT_TRUE(pivot) << pivot.why_not;
        const Vec3 off = pivot->grip_from_tip_m - kTip;
        squares += glm::dot(off, off) / (3 * kTrials);
        said += pivot->tip_sd_m * pivot->tip_sd_m / kTrials;
        EXPECT_NEAR(pivot->residual_m, std::sqrt(3.0) * 0.001, 0.0004);
    }
    EXPECT_LT(std::sqrt(squares), std::sqrt(said)) << "the worst direction is named";
    EXPECT_GT(std::sqrt(squares), 0.4 * std::sqrt(said));
}

TEST(Pivot, TooLittleRotationIsRefused) {
    Random random(1);
    const auto refuse = [](const std::vector<Pose>& poses, const std::string& words) {
        const auto pivot = calibratePivot(poses);
        EXPECT_FALSE(pivot);
        EXPECT_NE(pivot.why_not.find(words), std::string::npos) << pivot.why_not;
    };
    refuse({}, "Eight poses");
    refuse(turnedAbout(random, 40, 0.1, 0.0), "too little");
    std::vector<Pose> about_one_axis, broken = turnedAbout(random, 40, 0.7, 0.0);
    for (int i = 0; i < 40; ++i) {
        const Quat turn = glm::angleAxis(0.03 * i, Vec3(0, 0, 1));
        about_one_axis.push_back({turn, kPivot - turn * kTip});
    }
    refuse(about_one_axis, "one axis");
    broken[7].rotation.x = std::nan("");
    refuse(broken, "not a number");
}

}  // namespace
}  // namespace stylet::xr::registration
