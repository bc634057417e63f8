#include "xr/registration/drift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Case;
using study::Method;
using study::Random;
using study::Truth;
using testing::HasSubstr;

StoredRegistration makeStored(const Truth& truth) {
    return {truth.stage_from_device, truth.scale, truth.stylus_from_tip_m,
            truth.grip_from_tip_m,   0.001,       0.0015};
}

// HZ-FORCE-13
TEST(Drift, AMovedDeviceIsDetectedAndAnUnmovedOneIsAccepted) {
    const Case c{.method = Method::held, .points = 3, .noise_m = 0.001};
    int held = 0, told = 0;
    for (std::uint64_t trial = 1; trial <= 200; ++trial) {
        Random random(trial);
        const Truth truth = study::makeTruth(c, random);
        const std::vector<Pair> touched = study::makePoints(c, truth, random);
        held += checkDrift(makeStored(truth), touched).valid;
        Truth moved = truth;  // the table was moved by a centimetre
        moved.stage_from_device.position_m += 0.01 * random.direction();
        const Drift drift = checkDrift(makeStored(truth), study::makePoints(c, moved, random));
        told += !drift.valid;
        EXPECT_NEAR(drift.moved_m, 0.01, 0.003);
    }
    EXPECT_GE(held, 196);
    EXPECT_EQ(told, 200);
}

// The rotation is about the centroid of the touches, so the mean error stays small.
TEST(Drift, ARotatedDeviceIsDetected) {
    const Case c{.method = Method::held, .points = 8, .noise_m = 0.0005};
    Random random(3);
    const Truth truth = study::makeTruth(c, random);
    std::vector<Pair> touched = study::makePoints(c, truth, random);
    EXPECT_TRUE(checkDrift(makeStored(truth), touched).valid);
    Vec3 middle(0.0);
    for (const Pair& pair : touched)
        middle += pair.stage_from_grip.position_m / double(touched.size());
    const Quat turn = glm::angleAxis(0.17, glm::normalize(Vec3(1.0, 2.0, 2.0)));
    for (Pair& pair : touched) {
        pair.stage_from_grip.position_m = middle + turn * (pair.stage_from_grip.position_m - middle);
        pair.stage_from_grip.rotation = turn * pair.stage_from_grip.rotation;
    }
    EXPECT_FALSE(checkDrift(makeStored(truth), touched).valid);
}

// HZ-TEACH-06
TEST(Drift, TheMessageIsInMillimetres) {
    Random random(1);
    const Case exact{.method = Method::held, .points = 1, .noise_m = 0.0};
    const Truth truth = study::makeTruth(exact, random);
    std::vector<Pair> touched = study::makePoints(exact, truth, random);
    EXPECT_THAT(checkDrift(makeStored(truth), touched).what, HasSubstr("still where it was: 0.0 mm off"));
    touched[0].stage_from_grip.position_m.y += 0.02;
    EXPECT_THAT(checkDrift(makeStored(truth), touched).what, HasSubstr("moved by about 20.0 mm"));
    touched[0].stage_from_grip.position_m.y = std::nan("");
    EXPECT_FALSE(checkDrift(makeStored(truth), touched).valid);
    EXPECT_THAT(checkDrift(makeStored(truth), touched).what, HasSubstr("not a number"));
    EXPECT_FALSE(checkDrift(makeStored(truth), {}).valid);
}

}  // namespace
}  // namespace stylet::xr::registration
