#include "haptics/loop/trace.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::haptics {
namespace {

Quat aboutZ(double radians) {
    return {std::cos(radians / 2), 0.0, 0.0, std::sin(radians / 2)};
}

Trace twoPoses() {
    Trace t;
    t.samples = {{0, {aboutZ(0.0), {0.0, 0.0, 0.0}}, 1},
                 {10, {aboutZ(1.0), {1.0, 2.0, 0.0}}, 2},
                 {20, {aboutZ(1.0), {1.0, 2.0, 4.0}}, 4}};
    return t;
}

TEST(Trace, LinearBetweenSamplesAndHeldAtTheEnds) {
    const Trace t = twoPoses();
    std::size_t cursor = 0;
    EXPECT_EQ(sampleAt(t, -5, cursor).device_from_stylus.position_m, Vec3(0.0));
    const TraceSample half = sampleAt(t, 5, cursor);
    EXPECT_EQ(half.device_from_stylus.position_m, Vec3(0.5, 1.0, 0.0));
    EXPECT_NEAR(std::fabs(glm::dot(half.device_from_stylus.rotation, aboutZ(0.5))), 1.0, 1e-12);
    EXPECT_EQ(half.buttons, 1u);
    EXPECT_EQ(sampleAt(t, 10, cursor).buttons, 2u);
    EXPECT_EQ(sampleAt(t, 99, cursor).device_from_stylus.position_m, Vec3(1.0, 2.0, 4.0));
    EXPECT_EQ(sampleAt(t, 15, cursor).device_from_stylus.position_m, Vec3(1.0, 2.0, 2.0));  // back in time
}

TEST(Trace, RotationsTakeTheShorterArc) {
    Trace t = twoPoses();
    t.samples[1].device_from_stylus.rotation *= -1.0;  // the same rotation
    std::size_t cursor = 0;
    const Quat half = sampleAt(t, 5, cursor).device_from_stylus.rotation;
    EXPECT_NEAR(std::fabs(glm::dot(half, aboutZ(0.5))), 1.0, 1e-12);
}

TEST(Trace, EmptyTraceStaysAtTheOrigin) {
    std::size_t cursor = 3;
    EXPECT_EQ(sampleAt({}, 5, cursor).device_from_stylus.position_m, Vec3(0.0));
}

}  // namespace
}  // namespace stylet::haptics
