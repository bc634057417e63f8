#include "haptics/tools/probe.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/smoothstep.h"
#include "tests/haptics/along_x.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using patient::Surrogate;
using test::kAlongX;
using enum patient::Tissue;

// The array (the probe's +x) points along +z.
struct ProbeBench {
    explicit ProbeBench(double travel_m = 0.0) {
        if (travel_m != 0.0) package.motion = test::makeShift(travel_m);
    }
    ToolForce pressed(double depth_m, double z_m = 0.0, const Quat& turn = {1.0, 0.0, 0.0, 0.0}) {
        return stepProbe(state, settings, pad, {map, package.motion, breath},
                         {turn * kAlongX, {depth_m, 0.0, z_m}});
    }
    patient::Package package = test::makeSlabs({{skin, 0.002}, {soft, 0.058}}, 0.001);
    patient::Patient patient{package};
    TouchMap map = makeTouchMap(patient, makeSkin(patient, 2), 2);
    ProbeSettings settings{.length_m = 0.030};  // the slabs are 40 mm wide
    Pad pad = probePad(settings);
    ProbeState state;
    Surrogate breath;
};

// The fan of a convex face in closed form: 60 degrees around a centre 60 mm behind the face.
TEST(Probe, ScanLinesOfAConvexFaceFormAFan) {
    const ProbeSettings face;
    EXPECT_NEAR(fanHalfAngle_rad(face), M_PI / 6.0, 1e-12);
    for (const double angle : {-0.5, -0.1, 0.0, 0.3, 0.52}) {
        const Vec3 line(std::sin(angle), 0.0, std::cos(angle)), centre(0.0, 0.0, -0.060);
        for (const double depth_m : {0.0001, 0.05, 0.3}) {
            const auto start = scanLineStart(face, centre + (0.060 + depth_m) * line + Vec3(0.0, 0.004, 0.0));
            ASSERT_TRUE(start) << angle << " " << depth_m;
            EXPECT_LT(glm::length(*start - (centre + 0.060 * line)), 1e-12);
        }
    }
    for (const Vec3& missed : {Vec3(0.15, 0.0, 0.10), Vec3(-0.15, 0.0, 0.10), Vec3(0.0, 0.0, -0.001),
                               Vec3(0.0, 0.0, -0.2), Vec3(NAN, 0.0, 0.1), Vec3(0.0, 0.0, NAN)})
        EXPECT_FALSE(scanLineStart(face, missed)) << missed.x << " " << missed.z;
}

TEST(Probe, ScanLinesOfAFlatFaceAreAlmostParallel) {
    const ProbeSettings face{.length_m = 0.040, .curvature_m = 10.0};
    for (const double x_m : {-0.0199, 0.0, 0.015}) {
        const auto start = scanLineStart(face, {x_m, 0.0, 0.040});
        ASSERT_TRUE(start) << x_m;
        EXPECT_NEAR(start->x, x_m, 1e-4);
        EXPECT_NEAR(start->z, 0.0, 3e-5);
    }
    EXPECT_FALSE(scanLineStart(face, {0.0205, 0.0, 0.040}));
    EXPECT_FALSE(scanLineStart(face, {-0.0205, 0.0, 0.040}));
}

TEST(Probe, TouchesFromTheMiddleOutward) {
    ProbeBench s;
    EXPECT_EQ(s.pressed(-0.0001).force_n, Vec3(0.0));
    EXPECT_EQ(s.state.touching_share, 0.0);
    s.pressed(0.0004);
    const double light = s.state.touching_share;
    EXPECT_GT(light, 0.2);
    EXPECT_LT(light, 0.8);
    // The cylinder's sagitta over 15 mm is 1.9 mm. Deeper than that, the whole face touches.
    s.pressed(0.0022);
    EXPECT_EQ(s.state.touching_share, 1.0);
}

TEST(Probe, PressureIsForceOverArea) {
    ProbeBench s;
    const double area_m2 = s.settings.length_m * s.settings.width_m;
    const ToolForce f = s.pressed(0.006);
    EXPECT_NEAR(s.state.pressure_pa * area_m2, -f.force_n.x, 1e-4 * -f.force_n.x);
    // Layers as springs: the mean depth of the face times the pad's stiffness.
    double mean_m = 0.006;
    for (int i = 0; i < s.pad.count; ++i)
        mean_m -= s.pad.points_m[std::size_t(i)].z / s.pad.count;
    const auto young = [&](patient::Tissue t) { return s.package.elasticity[std::size_t(t)].young_pa; };
    const double k = area_m2 / (0.002 / young(skin) + 0.038 / young(soft));
    EXPECT_NEAR(-f.force_n.x / (k * mean_m), 1.0, 1e-3);
    EXPECT_LT(glm::length(f.torque_n_m), 1e-5);
}

TEST(Probe, TiltingLosesContactAtOneEnd) {
    ProbeBench s;
    s.pressed(0.003, 0.0, glm::angleAxis(0.35, Vec3(0.0, 1.0, 0.0)));
    EXPECT_GT(s.state.touching_share, 0.3);
    EXPECT_LT(s.state.touching_share, 0.9);
}

TEST(Probe, SlidesOnGel) {
    ProbeBench s;
    const double normal_n = -s.pressed(0.004).force_n.x;
    ToolForce f;
    for (int i = 1; i <= 50; ++i)
        f = s.pressed(0.004, 1e-4 * i);
    EXPECT_NEAR(-f.force_n.z / (s.settings.pad.friction * normal_n), 1.0, 1e-3);
}

// A chest that rises by `travel_m` along x with v, so that the skin moves out and in.
patient::MotionModel chestRise(double travel_m) {
    return test::makeMotion(Vec3(0.2), 0.01, [&](const Vec3& p) {
        test::MotionPoint m;
        const double fade = smoothStep(0.19, 0.1, std::fabs(p.x)) * smoothStep(0.19, 0.1, std::fabs(p.y)) *
                            smoothStep(0.19, 0.1, std::fabs(p.z));
        m.wall_a1_m = {-travel_m * fade, 0.0, 0.0};
        m.level_m = 1.0;
        return m;
    });
}

TEST(ParkedProbe, RidesTheSkinAlongItsNormal) {
    ProbeBench s;
    const patient::MotionModel motion = chestRise(0.008);
    Surrogate breath{0.2, 0.0, 0.0};
    const Vec3 at_m{0.002 - 0.2 * 0.008, 0.001, 0.003};
    SkinFollower follower = parkOnSkin({s.map, motion, breath}, {kAlongX, at_m});
    EXPECT_NEAR(follower.level_m, -0.002, 1e-5);
    EXPECT_NEAR(glm::length(follower.outward - Vec3(-1.0, 0.0, 0.0)), 0.0, 1e-4);
    Vec3 ridden_m(0.0);
    for (int i = 0; i < 800; ++i) {
        breath.v = 0.2 + 0.001 * i;
        ridden_m += followSkin(follower, {s.map, motion, breath});
        // The depth in the skin has not changed.
        EXPECT_NEAR(touchAt(s.map, referenceFromDeformed(motion, breath, follower.at_m)).level_m,
                    follower.level_m, 1e-6);
    }
    EXPECT_NEAR(ridden_m.x, -0.008 * 0.799, 1e-4);
    EXPECT_LT(std::fabs(ridden_m.y) + std::fabs(ridden_m.z), 1e-5);
}

// Under slanted skin the cavity moves on its own. The skin's motion must not be derived from the cavity.
TEST(ParkedProbe, FindsTheSkinsNormalOutsideTheCavity) {
    const Vec3 outward = glm::normalize(Vec3(-0.9, 0.0, -0.4));
    TouchMap map{{{41, 41, 41}, Vec3(0.002), Vec3(-0.040)}, {}};
    map.nodes.assign(3 * map.grid.voxelCount(), 0.0f);
    forEachVoxel(map.grid, [&](const Index3& i) {
        map.nodes[3 * map.grid.offset(i)] = float(glm::dot(outward, map.grid.centre(i)));
    });
    const patient::MotionModel motion = test::makeMotion(Vec3(0.1), 0.005, [&](const Vec3& p) {
        test::MotionPoint m;
        m.slide_a1_m = Vec3(0.004, 0.0, -0.004);
        m.level_m = glm::dot(outward, p) + 0.002;
        return m;
    });
    const double half = 0.5 * std::atan2(0.4, 0.9);
    const Quat facing = Quat{std::cos(half), 0.0, -std::sin(half), 0.0} * kAlongX;
    ASSERT_LT(glm::length(facing * Vec3(0.0, 0.0, 1.0) - outward), 1e-12);
    const SkinFollower follower = parkOnSkin({map, motion, {1.0, 0.0, 0.0}}, {facing, Vec3(0.0)});
    EXPECT_LT(glm::length(follower.outward - outward), 1e-3);
}

TEST(ParkedProbe, DoesNotFollowSkinSlidingUnderIt) {
    ProbeBench s(-0.010);
    SkinFollower follower = parkOnSkin({s.map, s.package.motion, {}}, {kAlongX, {0.003, 0.0, 0.0}});
    for (int i = 0; i <= 100; ++i)
        EXPECT_LT(glm::length(followSkin(follower, {s.map, s.package.motion, {0.01 * i, 0.0, 0.0}})), 1e-6);
}

}  // namespace
}  // namespace stylet::haptics
