// Fits all unknowns together: exact without noise, robust against outliers, and cautious where the data is
// insufficient.
#include "xr/registration/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Case;
using study::makePoints;
using study::makeTruth;
using study::Method;
using study::Random;
using study::Truth;
using testing::HasSubstr;

const Case kHard{
    .method = Method::held, .points = 20, .noise_m = 0.0, .gimbal_m = 0.003, .scale_error = 0.005};

FitSettings knownTipSettings(const Truth& truth) {
    FitSettings settings;
    settings.tip_guess_m = truth.grip_from_tip_m;
    return settings;
}

// Settings whose priors have no effect.
FitSettings allFreeSettings(const Truth& truth) {
    FitSettings settings = knownTipSettings(truth);
    settings.noise_m = 1e-6;
    settings.scale_sd = 1.0, settings.gimbal_sd_m = 1.0;
    return settings;
}

TEST(Fit, ScaleGimbalAndPoseAreRecovered) {
    Random random(1);
    const Truth truth = makeTruth(kHard, random);
    const auto fit = fitPairs(makePoints(kHard, truth, random), allFreeSettings(truth));
    ASSERT_TRUE(fit) << fit.why_not;
    EXPECT_LT(angleBetween(fit->stage_from_device.rotation, truth.stage_from_device.rotation), 1e-5);
    EXPECT_LT(glm::distance(fit->stage_from_device.position_m, truth.stage_from_device.position_m), 1e-5);
    EXPECT_NEAR(fit->scale, truth.scale, 1e-5);
    EXPECT_LT(glm::distance(fit->stylus_from_tip_m, truth.stylus_from_tip_m), 1e-5);
    EXPECT_EQ(fit->rejected, 0);
    EXPECT_LT(fit->fre_m, 1e-6);
}

// Enough poses with rotation also determine the controller's tip. Its prior of 1 m has practically no effect.
TEST(Fit, TheTipIsEstimatedFromThePointsAlone) {
    Case many = kHard;
    many.points = 34;
    Random random(2);
    const Truth truth = makeTruth(many, random);
    std::vector<Pair> pairs = makePoints(many, truth, random);
    const std::vector<Pair> more = makePoints(many, truth, random);
    pairs.insert(pairs.end(), more.begin(), more.end());
    FitSettings settings = allFreeSettings(truth);
    settings.tip = true;
    settings.tip_guess_m = Vec3(0.0);
    settings.tip_sd_m = 1.0;
    const auto fit = fitPairs(pairs, settings);
    ASSERT_TRUE(fit) << fit.why_not;
    EXPECT_LT(glm::distance(fit->grip_from_tip_m, truth.grip_from_tip_m), 1e-5);
    EXPECT_LT(glm::distance(fit->stylus_from_tip_m, truth.stylus_from_tip_m), 1e-5);
    EXPECT_GT(fit->max_rotation_rad, 0.5);
}

// A clock error that remains in the pairs is found from the velocities.
TEST(Fit, TheRemainingLatencyIsEstimatedFromVelocities) {
    Case c = kHard;
    Random random(3);
    const Truth truth = makeTruth(c, random);
    std::vector<Pair> pairs = makePoints(c, truth, random);
    for (Pair& pair : pairs) {
        pair.tip_m_per_s = 0.1 * random.direction();
        pair.device_from_stylus.position_m += 0.012 * pair.tip_m_per_s;  // read 12 ms late
    }
    FitSettings settings = allFreeSettings(truth);
    settings.latency = true, settings.latency_sd_s = 1.0;
    const auto fit = fitPairs(pairs, settings);
    ASSERT_TRUE(fit) << fit.why_not;
    EXPECT_NEAR(fit->latency_s, 0.012, 1e-5);
    EXPECT_NEAR(fit->scale, truth.scale, 1e-5);
}

// HZ-TEACH-06
TEST(Fit, OutliersAreRejectedIndividually) {
    Random random(4);
    Case c = kHard;
    c.points = 12, c.noise_m = 0.0005;
    const Truth truth = makeTruth(c, random);
    std::vector<Pair> pairs = makePoints(c, truth, random);
    pairs[2].stage_from_grip.position_m += Vec3(0.02, 0.0, 0.0);
    pairs[7].stage_from_grip.position_m += Vec3(0.0, -0.05, 0.05);
    pairs[11].stage_from_grip.position_m += Vec3(0.0, 0.0, 2.0);
    const auto fit = fitPairs(pairs, knownTipSettings(truth));
    ASSERT_TRUE(fit) << fit.why_not;
    EXPECT_EQ(fit->rejected, 3);
    for (std::size_t i = 0; i < pairs.size(); ++i)
        EXPECT_EQ(fit->used[i], i != 2 && i != 7 && i != 11) << i;
    for (const Vec3& place : chooseTouchPlaces(Cube{}, 8))
        EXPECT_LT(glm::distance(fit->inStage({{}, place}), truth.inStage({{}, place})), 0.003);
}

// If only the pose is estimated and only the points are noisy, the predicted error equals Fitzpatrick's.
TEST(Fit, ThePredictionMatchesTheoryForAPureRigidFit) {
    Random random(5);
    const Case c{.method = Method::plain, .points = 8};
    const Truth truth = makeTruth(c, random);
    FitSettings settings = knownTipSettings(truth);
    settings.scale = settings.gimbal = false;
    settings.noise_pairs = 1e9;  // the noise is known
    const auto fit = fitPairs(makePoints(c, truth, random), settings);
    ASSERT_TRUE(fit) << fit.why_not;
    const CubeError theory = expectedTreInCube(Cube{}, chooseTouchPlaces(Cube{}, 8), std::sqrt(3.0) * 0.001);
    EXPECT_NEAR(fit->tre.mean_m, theory.mean_m, 1e-3 * theory.mean_m);
    EXPECT_NEAR(fit->tre.worst_m, theory.worst_m, 1e-3 * theory.worst_m);
}

// The controller is strapped to the handle and was never pivoted. Its tip is then unobservable, and the fit
// must predict a large error.
// HZ-TEACH-06
TEST(Fit, UndeterminedUnknownsKeepTheirPriorUncertainty) {
    Random random(6);
    const Case c{.method = Method::held, .points = 34, .noise_m = 0.0005};
    Truth truth = makeTruth(c, random);
    const Quat mount = random.turn(3.0);
    std::vector<Pair> pairs = makePoints(c, truth, random);
    for (Pair& pair : pairs) {
        const Quat turn = truth.stage_from_device.rotation * pair.device_from_stylus.rotation * mount;
        pair.stage_from_grip = {turn, truth.inStage(pair.device_from_stylus) - turn * truth.grip_from_tip_m};
    }
    FitSettings settings;
    settings.tip = true;
    const auto fit = fitPairs(pairs, settings);
    ASSERT_TRUE(fit) << fit.why_not;
    EXPECT_GT(fit->gimbal_sd_m, 0.9 * std::sqrt(3.0) * settings.gimbal_sd_m) << "no more than the prior";
    EXPECT_GT(fit->tre.mean_m, 0.004);
    EXPECT_FALSE(evaluateFit(*fit).accept);
}

TEST(Fit, DegenerateInputIsRefusedWithAReason) {
    Random random(7);
    const Truth truth = makeTruth(kHard, random);
    const std::vector<Pair> good = makePoints(kHard, truth, random);
    const auto why = [&](const std::vector<Pair>& pairs) {
        const auto fit = fitPairs(pairs, knownTipSettings(truth));
        EXPECT_FALSE(fit);
        return fit.why_not;
    };
    EXPECT_THAT(why({}), HasSubstr("too few"));
    EXPECT_THAT(why({good.begin(), good.begin() + 3}), HasSubstr("too few"));
    EXPECT_THAT(why(std::vector<Pair>(9, good[0])), HasSubstr("again and again"));
    std::vector<Pair> line = good, plane = good, broken = good, nonsense = good;
    for (std::size_t i = 0; i < line.size(); ++i)
        line[i].device_from_stylus.position_m = Vec3(0.01 * double(i), 0.01, 0.01);
    for (Pair& pair : plane)
        pair.device_from_stylus.position_m.z = 0.01;
    EXPECT_THAT(why(line), HasSubstr("a line"));
    EXPECT_THAT(why(plane), HasSubstr("a plane"));
    broken[4].stage_from_grip.position_m.x = std::nan("");
    EXPECT_THAT(why(broken), HasSubstr("not a number"));
    for (Pair& pair : nonsense)
        pair.stage_from_grip.position_m = random.inCube(1.0);
    const auto fit = fitPairs(nonsense, knownTipSettings(truth));
    EXPECT_TRUE(!fit || !evaluateFit(*fit).accept);
    FitSettings vague = knownTipSettings(truth);
    vague.tip = true;
    EXPECT_THAT(fitPairs({good.begin(), good.begin() + 8}, vague).why_not, HasSubstr("too few"));
}

// The controller reports the same pose for all points, while the device moves.
// HZ-TEACH-06
TEST(Fit, AMotionlessControllerIsRefused) {
    Random random(8);
    const Truth truth = makeTruth(kHard, random);
    std::vector<Pair> pairs = makePoints(kHard, truth, random);
    for (Pair& pair : pairs)
        pair.stage_from_grip = pairs[0].stage_from_grip;
    EXPECT_FALSE(fitPairs(pairs, knownTipSettings(truth)));
}

TEST(EvaluateFit, EveryReasonHasItsOwnMessage) {
    Fit good;
    good.inliers = 8, good.fre_m = 0.001, good.tre = {0.0008, 0.0015};
    EXPECT_TRUE(evaluateFit(good).accept);
    EXPECT_THAT(evaluateFit(good).why, HasSubstr("about 0.8 mm"));
    const auto refuse = [&](auto change, const std::string& words) {
        Fit bad = good;
        change(bad);
        EXPECT_FALSE(evaluateFit(bad).accept);
        EXPECT_THAT(evaluateFit(bad).why, HasSubstr(words));
    };
    refuse([](Fit& f) { f.rejected = 6; }, "43 % of the points");
    refuse([](Fit& f) { f.fre_m = 0.006; }, "miss one another by 6.0 mm");
    refuse([](Fit& f) { f.scale = 1.05; }, "5.0 %");
    refuse([](Fit& f) { f.stylus_from_tip_m.x = 0.02; }, "20 mm");
    refuse([](Fit& f) { f.tre.mean_m = 0.003; }, "3.0 mm");
    refuse([](Fit& f) { f.tre.worst_m = 0.005; }, "5.0 at worst");
}

}  // namespace
}  // namespace stylet::xr::registration
