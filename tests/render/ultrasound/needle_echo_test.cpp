#include "render/ultrasound/needle_echo.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::render {
namespace {

// A shaft in the picture's plane that crosses the middle line at 60 mm, at `angle` to the lateral
// direction.
Pose across(double angle, double elevation_m = 0.0) {
    const Vec3 axis(std::cos(angle), 0.0, std::sin(angle)), y(0, 1, 0);
    const Vec3 tip = Vec3(0.0, elevation_m, 0.060) - 0.030 * axis;
    return {glm::quat_cast(glm::dmat3(y, glm::cross(axis, y), axis)), tip};
}

NeedleEcho middleLine(const Pose& needle, double share = 0.0) {
    const Transducer probe;
    return needleEcho(probe, scanLine(probe, share), 0.0005, needle, {}, 0.9);
}

TEST(NeedleEchoes, AreBrightestAtARightAngleAndHalfAtTheLobeEdge) {
    const NeedleEcho right = middleLine(across(0.0));
    EXPECT_NEAR(right.depth_m, 0.060, 1e-6);
    EXPECT_NEAR(right.amplitude, 0.9, 0.01);
    EXPECT_NEAR(right.shadow, 0.47, 0.03);
    EXPECT_NEAR(middleLine(across(0.5 * kNeedleLobe_rad)).amplitude / right.amplitude, 0.5, 0.03);
    EXPECT_LT(middleLine(across(M_PI / 4)).amplitude, 0.05);
    EXPECT_GT(middleLine(across(M_PI / 4)).amplitude, 0.005);
}

// HZ-TEACH-05
TEST(NeedleEchoes, AreVisibleOnlyWithinTheBeamThickness) {
    const double sigma = beamThickness_m(Transducer{}, 0.060) / kWidthsPerSigma;
    const double full = middleLine(across(0.0)).amplitude;
    EXPECT_NEAR(middleLine(across(0.0, sigma)).amplitude / full, std::exp(-0.5), 0.01);
    EXPECT_NEAR(middleLine(across(0.0, 2.0 * sigma)).amplitude / full, std::exp(-2.0), 0.01);
    EXPECT_EQ(middleLine(across(0.0, 0.010)).amplitude, 0.0);
}

// HZ-TEACH-05
TEST(NeedleEchoes, EndAtTheTip) {
    // The tip lies 30 mm to the left of the middle. Lines beyond it have no echo.
    EXPECT_GT(middleLine(across(0.0), -0.35).amplitude, 0.1);
    EXPECT_EQ(middleLine(across(0.0), -0.80).amplitude, 0.0);
}

// A shaft perpendicular to the picture's plane appears as a dot.
TEST(NeedleEchoes, ShaftThroughThePlaneIsADot) {
    const Pose through{glm::angleAxis(-M_PI / 2, Vec3(1, 0, 0)), Vec3(0.0, -0.050, 0.060)};
    EXPECT_NEAR(glm::length(through.direction({0, 0, 1}) - Vec3(0, 1, 0)), 0.0, 1e-9);
    const NeedleEcho hit = middleLine(through);
    EXPECT_NEAR(hit.depth_m, 0.060, 1e-6);
    EXPECT_GT(hit.amplitude, 0.5);
    EXPECT_EQ(middleLine(through, 0.1).amplitude, 0.0);  // 6 mm beside it
}

TEST(NeedleEchoes, NeedleAlongTheBeamOrBehindTheFaceIsHandled) {
    const Pose along{glm::angleAxis(M_PI, Vec3(1, 0, 0)), Vec3(0.0, 0.0, 0.060)};
    EXPECT_TRUE(std::isfinite(middleLine(along).amplitude));
    const Pose behind{{1, 0, 0, 0}, Vec3(0.0, 0.0, -0.300)};
    EXPECT_EQ(middleLine(behind).amplitude, 0.0);
}

// The shadow is half at the tip. It becomes none and full a quarter of the aperture (6 mm) to either side.
TEST(NeedleEchoes, ShadowEdgeWidthMatchesTheAperture) {
    Transducer flat;
    flat.shape = TransducerShape::linear;
    flat.width_m = 0.060;
    constexpr std::size_t kLines = 121;  // 0.5 mm apart
    std::vector<NeedleEcho> lines(kLines);
    for (std::size_t i = 60; i < kLines; ++i)
        lines[i] = {0.040, 0.5, 0.6};
    spreadShadows(flat, lines);
    EXPECT_NEAR(lines[60].shadow, 0.3, 0.02);
    EXPECT_NEAR(lines[54].shadow, 0.3 * (1.0 - 3.0 / 6.0), 0.02);
    EXPECT_EQ(lines[40].shadow, 0.0);
    EXPECT_EQ(lines[40].depth_m, 0.0);
    EXPECT_NEAR(lines[80].shadow, 0.6, 1e-9);
    EXPECT_NEAR(lines[kLines - 1].shadow, 0.6, 1e-9);
    EXPECT_EQ(lines[54].depth_m, 0.040);
    EXPECT_EQ(lines[54].amplitude, 0.0) << "beside the needle there is no echo";
    std::vector<NeedleEcho> none(kLines);
    spreadShadows(flat, none);
    EXPECT_EQ(none[60].depth_m, 0.0);
}

}  // namespace
}  // namespace stylet::render
