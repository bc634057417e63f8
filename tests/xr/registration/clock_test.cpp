// The offset between two streams of one motion is estimated to a fraction of a sample.
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
using study::Method;
using study::Random;
using study::Streams;
using study::Truth;
using testing::HasSubstr;

// Converts the grip positions to tip positions. The estimate compares speeds, and only the controller's tip
// moves like the device.
std::vector<TimedPose> makeTips(const Streams& streams, const Truth& truth) {
    std::vector<TimedPose> tips = streams.tracked;
    for (TimedPose& s : tips)
        s.pose.position_m = s.pose * truth.grip_from_tip_m;
    return tips;
}

TEST(Clock, TheOffsetIsFoundWithSubSampleAccuracy) {
    for (const double delay_s : {-0.05, -0.0133, 0.0, 0.0071, 0.02, 0.0444, 0.11}) {
        const Case c{.method = Method::motion, .noise_m = 0.0002, .delay_s = delay_s};
        Random random(7);
        const Truth truth = makeTruth(c, random);
        const Streams streams = makeMotion(c, truth, random);
        const auto offset = estimateClockOffset(streams.device, makeTips(streams, truth));
        ASSERT_TRUE(offset) << offset.why_not;
        EXPECT_NEAR(offset->delay_s, delay_s, 0.003) << "samples come every 11 and 4 ms";
        EXPECT_GT(offset->correlation, 0.9);
    }
}

TEST(Clock, TheFitRefinesTheOffsetToAMillisecondDespiteNoiseAndJumps) {
    const Case c{
        .method = Method::motion, .gimbal_m = 0.003, .scale_error = 0.005, .delay_s = 0.02, .outliers = 0.1};
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
        EXPECT_TRUE(evaluateFit(*fit).accept) << evaluateFit(*fit).why;
        for (const Vec3& place : chooseTouchPlaces(Cube{}, 8))
            EXPECT_LT(glm::distance(fit->inStage({{}, place}), truth.inStage({{}, place})), 0.0015);
    }
}

// Correlated noise adds no information. The predicted error must grow with its correlation time.
TEST(Clock, CorrelatedNoiseRaisesThePredictedError) {
    Case c{.method = Method::motion};
    Random random(3), again(3);
    const Truth truth = makeTruth(c, random);
    makeTruth(c, again);
    const Streams white = makeMotion(c, truth, random);
    c.correlation_time_s = 0.3;
    const Streams slow = makeMotion(c, truth, again);
    FitSettings settings;
    settings.tip_guess_m = truth.grip_from_tip_m;
    const auto a = fitMotion(white.device, white.tracked, settings),
               b = fitMotion(slow.device, slow.tracked, settings);
    ASSERT_TRUE(a && b);
    EXPECT_GT(a->effective_pairs, 8.0 * b->effective_pairs);
    EXPECT_GT(b->tre.mean_m, 2.0 * a->tre.mean_m);
}

TEST(Clock, UnrelatedStreamsAreRefused) {
    const Case c{.method = Method::motion};
    Random random(3);
    const Truth truth = makeTruth(c, random);
    const Streams one = makeMotion(c, truth, random), other = makeMotion(c, truth, random);
    const std::vector<TimedPose> tips = makeTips(one, truth);
    EXPECT_THAT(estimateClockOffset(one.device, makeTips(other, truth)).why_not,
                HasSubstr("does not move as"));
    EXPECT_THAT(estimateClockOffset(one.device, {}).why_not, HasSubstr("no motion"));
    EXPECT_THAT(estimateClockOffset(PoseStream(one.device).first(200), tips).why_not,
                HasSubstr("two seconds"));
    std::vector<TimedPose> still = one.device, broken = one.device, far_off = tips;
    for (TimedPose& s : still)
        s.pose.position_m = Vec3(0.0);
    EXPECT_THAT(estimateClockOffset(still, tips).why_not, HasSubstr("too little motion"));
    broken[100].pose.position_m.z = std::numeric_limits<double>::infinity();
    EXPECT_THAT(estimateClockOffset(broken, tips).why_not, HasSubstr("not a number"));
    for (TimedPose& s : far_off)
        s.t_s += 1.0;
    EXPECT_FALSE(estimateClockOffset(one.device, far_off));
}

TEST(Clock, GapsAndTimesOutsideAreNotInterpolated) {
    const std::vector<TimedPose> stream = {
        {0.0, {}}, {0.05, {{}, Vec3(1, 0, 0)}}, {0.3, {{}, Vec3(2, 0, 0)}}};
    EXPECT_FALSE(poseAt(stream, -0.001));
    EXPECT_FALSE(poseAt(stream, 0.301));
    EXPECT_FALSE(poseAt(stream, 0.1)) << "a gap of a quarter of a second";
    ASSERT_TRUE(poseAt(stream, 0.025));
    EXPECT_NEAR(poseAt(stream, 0.025)->position_m.x, 0.5, 1e-12);
    EXPECT_EQ(poseAt(stream, 0.3)->position_m.x, 2.0);
    EXPECT_FALSE(poseAt({}, 0.0));
    EXPECT_FALSE(meanPose({}));
    const auto held = meanPose(PoseStream(stream).first(2));
    ASSERT_TRUE(held);
    EXPECT_NEAR(held->pose.position_m.x, 0.5, 1e-12);
    EXPECT_NEAR(held->spread_m, 0.5, 1e-12);
}

}  // namespace
}  // namespace stylet::xr::registration
