#include "xr/registration/drift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Case;
using study::Random;
using study::Truth;
using study::Way;
using testing::HasSubstr;

Stored storedOf(const Truth& truth) {
    return {truth.stage_from_device, truth.scale, truth.stylus_from_tip_m,
            truth.grip_from_tip_m,   0.001,       0.0015};
}

// HZ-FORCE-13
TEST(Drift, WhatStayedHoldsAndWhatMovedIsTold) {
    const Case c{.way = Way::held, .points = 3, .noise_m = 0.001};
    int held = 0, told = 0;
    for (std::uint64_t trial = 1; trial <= 200; ++trial) {
        Random random(trial);
        const Truth truth = study::makeTruth(c, random);
        const std::vector<Pair> touched = study::makePoints(c, truth, random);
        held += judgeDrift(storedOf(truth), touched).holds;
        Truth moved = truth;  // the table was moved by a centimetre
        moved.stage_from_device.position_m += 0.01 * random.direction();
        const Drift drift = judgeDrift(storedOf(truth), study::makePoints(c, moved, random));
        told += !drift.holds;
        EXPECT_NEAR(drift.moved_m, 0.01, 0.003);
    }
    EXPECT_GE(held, 196);
    EXPECT_EQ(told, 200);
}

// Rotated about the centroid of the touches, which stays in place.
TEST(Drift, ATurnedDeviceIsToldToo) {
    const Case c{.way = Way::held, .points = 8, .noise_m = 0.0005};
    Random random(3);
    const Truth truth = study::makeTruth(c, random);
    std::vector<Pair> touched = study::makePoints(c, truth, random);
    EXPECT_TRUE(judgeDrift(storedOf(truth), touched).holds);
    Vec3 middle(0.0);
    for (const Pair& pair : touched)
        middle += pair.stage_from_grip.position_m / double(touched.size());
    const Quat turn = glm::angleAxis(0.17, glm::normalize(Vec3(1.0, 2.0, 2.0)));
    for (Pair& pair : touched) {
        pair.stage_from_grip.position_m = middle + turn * (pair.stage_from_grip.position_m - middle);
        pair.stage_from_grip.rotation = turn * pair.stage_from_grip.rotation;
    }
    EXPECT_FALSE(judgeDrift(storedOf(truth), touched).holds);
}

// HZ-TEACH-06
TEST(Drift, SaysSoInMillimetres) {
    Random random(1);
    const Case exact{.way = Way::held, .points = 1, .noise_m = 0.0};
    const Truth truth = study::makeTruth(exact, random);
    std::vector<Pair> touched = study::makePoints(exact, truth, random);
    EXPECT_THAT(judgeDrift(storedOf(truth), touched).what, HasSubstr("still where it was: 0.0 mm off"));
    touched[0].stage_from_grip.position_m.y += 0.02;
    EXPECT_THAT(judgeDrift(storedOf(truth), touched).what, HasSubstr("moved by about 20.0 mm"));
    touched[0].stage_from_grip.position_m.y = std::nan("");
    EXPECT_FALSE(judgeDrift(storedOf(truth), touched).holds);
    EXPECT_THAT(judgeDrift(storedOf(truth), touched).what, HasSubstr("not a number"));
    EXPECT_FALSE(judgeDrift(storedOf(truth), {}).holds);
}

}  // namespace
}  // namespace stylet::xr::registration
