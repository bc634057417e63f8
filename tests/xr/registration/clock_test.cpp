// Two streams of one motion: estimates the offset between their clocks to a fraction of a sample.
#include "xr/registration/clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Case;
using study::makeMotion;
using study::makeTruth;
using study::Random;
using study::Streams;
using study::Truth;
using study::Way;
using testing::HasSubstr;

// Uses tip positions, because the grips move differently.
std::vector<Timed> tipsOf(const Streams& streams, const Truth& truth) {
    std::vector<Timed> tips = streams.tracked;
    for (Timed& s : tips)
        s.pose.position_m = s.pose * truth.grip_from_tip_m;
    return tips;
}

TEST(Clock, TheOffsetIsFoundBetweenSamples) {
    for (const double late_s : {-0.05, -0.0133, 0.0, 0.0071, 0.02, 0.0444, 0.11}) {
        const Case c{.way = Way::motion, .noise_m = 0.0002, .late_s = late_s};
        Random random(7);
        const Truth truth = makeTruth(c, random);
        const Streams streams = makeMotion(c, truth, random);
        const auto offset = clockOffset(streams.device, tipsOf(streams, truth));
        ASSERT_TRUE(offset) << offset.why_not;
        EXPECT_NEAR(offset->late_s, late_s, 0.003) << "samples come every 11 and 4 ms";
        EXPECT_GT(offset->correlation, 0.9);
    }
}

TEST(Clock, TheFitBringsItToAMillisecondThroughNoiseAndJumps) {
    const Case c{
        .way = Way::motion, .gimbal_m = 0.003, .scale_error = 0.005, .late_s = 0.02, .outliers = 0.1};
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        Random random(seed);
        const Truth truth = makeTruth(c, random);
        const Streams streams = makeMotion(c, truth, random);
        FitSettings settings;
        settings.tip = true, settings.tip_guess_m = truth.grip_from_tip_m, settings.tip_sd_m = 0.0005;
        const auto fit = fitMotion(streams.device, streams.tracked, settings);
        ASSERT_TRUE(fit) << fit.why_not;
        EXPECT_NEAR(fit->latency_s, 0.02, 0.003);
        EXPECT_GT(fit->rejected, 30);
        EXPECT_TRUE(judge(*fit).accept) << judge(*fit).why;
        for (const Vec3& place : spreadPlaces(Cube{}, 8))
            EXPECT_LT(glm::distance(fit->inStage({{}, place}), truth.inStage({{}, place})), 0.0015);
    }
}

// Correlated noise adds no information. The predicted error must grow with its correlation time.
TEST(Clock, NoiseThatLastsIsNotAveragedAwayOnPaper) {
    Case c{.way = Way::motion};
    Random random(3), again(3);
    const Truth truth = makeTruth(c, random);
    makeTruth(c, again);
    const Streams white = makeMotion(c, truth, random);
    c.memory_s = 0.3;
    const Streams slow = makeMotion(c, truth, again);
    FitSettings settings;
    settings.tip_guess_m = truth.grip_from_tip_m;
    const auto a = fitMotion(white.device, white.tracked, settings),
               b = fitMotion(slow.device, slow.tracked, settings);
    ASSERT_TRUE(a && b);
    EXPECT_GT(a->independent, 8.0 * b->independent);
    EXPECT_GT(b->tre.mean_m, 2.0 * a->tre.mean_m);
}

TEST(Clock, WhatDoesNotBelongTogetherIsRefused) {
    const Case c{.way = Way::motion};
    Random random(3);
    const Truth truth = makeTruth(c, random);
    const Streams one = makeMotion(c, truth, random), other = makeMotion(c, truth, random);
    const std::vector<Timed> tips = tipsOf(one, truth);
    EXPECT_THAT(clockOffset(one.device, tipsOf(other, truth)).why_not, HasSubstr("does not move as"));
    EXPECT_THAT(clockOffset(one.device, {}).why_not, HasSubstr("no motion"));
    EXPECT_THAT(clockOffset(Stream(one.device).first(200), tips).why_not, HasSubstr("two seconds"));
    std::vector<Timed> still = one.device, broken = one.device, far_off = tips;
    for (Timed& s : still)
        s.pose.position_m = Vec3(0.0);
    EXPECT_THAT(clockOffset(still, tips).why_not, HasSubstr("too little motion"));
    broken[100].pose.position_m.z = std::numeric_limits<double>::infinity();
    EXPECT_THAT(clockOffset(broken, tips).why_not, HasSubstr("not a number"));
    for (Timed& s : far_off)
        s.t_s += 1.0;
    EXPECT_FALSE(clockOffset(one.device, far_off));
}

TEST(Clock, NothingIsMadeUpInGapsOrOutside) {
    const std::vector<Timed> stream = {{0.0, {}}, {0.05, {{}, Vec3(1, 0, 0)}}, {0.3, {{}, Vec3(2, 0, 0)}}};
    EXPECT_FALSE(poseAt(stream, -0.001));
    EXPECT_FALSE(poseAt(stream, 0.301));
    EXPECT_FALSE(poseAt(stream, 0.1)) << "a gap of a quarter of a second";
    ASSERT_TRUE(poseAt(stream, 0.025));
    EXPECT_NEAR(poseAt(stream, 0.025)->position_m.x, 0.5, 1e-12);
    EXPECT_EQ(poseAt(stream, 0.3)->position_m.x, 2.0);
    EXPECT_FALSE(poseAt({}, 0.0));
    EXPECT_FALSE(meanPose({}));
    const auto held = meanPose(Stream(stream).first(2));
    ASSERT_TRUE(held);
    EXPECT_NEAR(held->pose.position_m.x, 0.5, 1e-12);
    EXPECT_NEAR(held->spread_m, 0.5, 1e-12);
}

}  // namespace
}  // namespace stylet::xr::registration
