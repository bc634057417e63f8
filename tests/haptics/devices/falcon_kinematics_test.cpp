#include "haptics/devices/falcon/falcon_kinematics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>
#include <vector>

#include "patient/synth/random.h"

namespace stylet::haptics::falcon {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

struct Poses {
    patient::synth::Random random{1, 0};
    Vec3 next() {
        return {random.uniform(-0.04, 0.04), random.uniform(-0.04, 0.04), random.uniform(0.08, 0.16)};
    }
};

// Central differences of the inverse kinematics.
glm::dmat3 differences(const Vec3& p) {
    constexpr double h = 1e-6;
    glm::dmat3 columns(0.0);
    for (int j = 0; j < 3; ++j) {
        Vec3 d(0.0);
        d[j] = h;
        columns[j] = (*anglesAt(p + d) - *anglesAt(p - d)) / (2.0 * h);
    }
    return columns;
}

double norm(const glm::dmat3& m) {
    return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

TEST(FalconKinematics, OnTheAxisTheLegsAgreeAndTheAnglesAreThePublishedOnes) {
    const double expected[][2] = {{0.11, 16.19}, {0.075, -18.3}, {0.17, 66.8}};
    for (const auto& [z_m, degrees] : expected) {
        const Angles angles = anglesAt({0.0, 0.0, z_m}).value();
        EXPECT_NEAR(angles.x * kDegrees, degrees, 0.06) << z_m;
        EXPECT_NEAR(angles.y, angles.x, 1e-12);
        EXPECT_NEAR(angles.z, angles.x, 1e-12);
    }
    EXPECT_NEAR(countsFromRadians(anglesAt(kCentre_m)->x), -516.0, 1.0);
}

TEST(FalconKinematics, AnEncoderCountIsThePublishedAngle) {
    EXPECT_NEAR((radiansFromCounts(1) - radiansFromCounts(0)) * kDegrees, 0.03643, 5e-6);
    EXPECT_NEAR(radiansFromCounts(0) * kDegrees, 35.0, 1e-12);
    EXPECT_NEAR(countsFromRadians(radiansFromCounts(-1234)), -1234.0, 1e-9);
    EXPECT_NEAR(2.0 * std::numbers::pi / (radiansFromCounts(1) - radiansFromCounts(0)), 9881.0, 1.0);
}

// In each leg the thigh, the elbow stubs and the sideways shin must form a closed chain: the remaining
// distance is the shin's length, 102.5 mm.
TEST(FalconKinematics, TheLegsCloseAtEveryPose) {
    Poses poses;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = poses.next();
        const Angles angles = anglesAt(p).value();
        for (int leg = 0; leg < 3; ++leg) {
            const double phi = (leg == 0 ? 90.0 : leg == 1 ? -30.0 : -150.0) / kDegrees + 15.0 / kDegrees;
            const double u = std::cos(phi) * p.x + std::sin(phi) * p.y - 0.0400;
            const double v = -std::sin(phi) * p.x + std::cos(phi) * p.y + 0.02309;
            const double flat =
                std::hypot(u + 0.01443 - 0.060 * std::cos(angles[leg]), p.z - 0.060 * std::sin(angles[leg]));
            EXPECT_NEAR(std::hypot(flat - 0.01125 - 0.01125, v - 0.025), 0.1025, 1e-12);
        }
    }
}

TEST(FalconKinematics, JacobianMatchesCentralDifferences) {
    Poses poses;
    double worst = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = poses.next();
        const glm::dmat3 expected = differences(p);
        worst = std::max(worst, norm(jacobianAt(p).value() - expected) / norm(expected));
    }
    EXPECT_LT(worst, 1e-7);
}

// The public driver squares the sine of the shin's angle in the z term. Its force points several degrees
// off, so the test above would detect the mistake.
TEST(FalconKinematics, SquaredSineOfThePublicDriverRotatesTheForce) {
    Poses poses;
    std::vector<double> turned_deg;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = poses.next();
        const glm::dmat3 right = jacobianAt(p).value();
        const Angles angles = anglesAt(p).value();
        glm::dmat3 rows = glm::transpose(right);
        for (int leg = 0; leg < 3; ++leg) {
            const double phi = (leg == 0 ? 105.0 : leg == 1 ? -15.0 : -135.0) / kDegrees;
            const double u = std::cos(phi) * p.x + std::sin(phi) * p.y - 0.0400 + 0.01443;
            const double rise = p.z - 0.060 * std::sin(angles[leg]);
            rows[leg].z *= rise / std::hypot(rise, u - 0.060 * std::cos(angles[leg]));
        }
        // Torques from the wrong matrix, and the force that they produce with the right one.
        const Vec3 wanted = poses.random.jitter3(1.0);
        const Vec3 torques = glm::inverse(rows) * wanted;  // rows = transpose of the wrong Jacobian
        const Vec3 made = glm::transpose(right) * torques;
        turned_deg.push_back(std::acos(glm::dot(made, wanted) / glm::length(made) / glm::length(wanted)) *
                             kDegrees);
    }
    std::sort(turned_deg.begin(), turned_deg.end());
    EXPECT_NEAR(turned_deg[1000], 4.8, 1.0);
    EXPECT_NEAR(turned_deg[1900], 12.0, 2.0);
}

TEST(FalconKinematics, ForwardKinematicsConvergesFromTheCentre) {
    Poses poses;
    double worst_m = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = poses.next();
        const auto found = gripFromAngles(anglesAt(p).value(), kCentre_m);
        ASSERT_TRUE(found) << p.x << ' ' << p.y << ' ' << p.z;
        worst_m = std::max(worst_m, glm::length(*found - p));
    }
    EXPECT_LT(worst_m, 1e-9);
}

TEST(FalconKinematics, ForwardKinematicsReportsUnreachablePoses) {
    const Angles good = anglesAt(kCentre_m).value();
    EXPECT_FALSE(gripFromAngles(good + Vec3(2.0, -2.0, 0.0), kCentre_m));
    EXPECT_FALSE(gripFromAngles(Vec3(std::nan("")), kCentre_m));
    EXPECT_TRUE(gripFromAngles(good, Vec3(std::nan(""))));  // starts again at the centre
    EXPECT_TRUE(gripFromAngles(good, {9.0, 0.0, 0.0}));
    EXPECT_FALSE(anglesAt({0.3, 0.0, 0.1}));
    EXPECT_FALSE(anglesAt({0.0, 0.0, 0.3}));
    EXPECT_FALSE(computeTorques({0.0, 0.0, 1.0}, {0.0, 0.0, 0.3}));
}

TEST(FalconKinematics, OneCountIsThePublishedDistance) {
    const glm::dmat3 grip_from_angles = glm::inverse(jacobianAt(kCentre_m).value());
    const double count_rad = radiansFromCounts(1) - radiansFromCounts(0);
    Vec3 squares(0.0);
    for (int leg = 0; leg < 3; ++leg)
        squares += grip_from_angles[leg] * grip_from_angles[leg] * count_rad * count_rad;
    EXPECT_NEAR(std::sqrt(squares.x), 42e-6, 1e-6);
    EXPECT_NEAR(std::sqrt(squares.y), 42e-6, 1e-6);
    EXPECT_NEAR(std::sqrt(squares.z), 27e-6, 1e-6);
}

// Virtual work: for any small motion, the motors' work equals the work done on the grip.
// HZ-FORCE-10
TEST(FalconKinematics, TorquesAndForceDoEqualVirtualWork) {
    Poses poses;
    for (int i = 0; i < 500; ++i) {
        const Vec3 p = poses.next(), force(poses.next() * 100.0), d = poses.next() * 1e-6;
        const Vec3 turned = *anglesAt(p + d) - *anglesAt(p - d);
        EXPECT_NEAR(glm::dot(computeTorques(force, p).value(), turned), glm::dot(force, 2.0 * d),
                    1e-7 * glm::length(force) * glm::length(d));
    }
}

// The public driver uses 10,000 counts per N m, so 4095 counts are 7.8 N sideways and 16.9 N along the
// axis.
TEST(FalconKinematics, FullCommandIsThePublishedForce) {
    const auto fullForce = [](const Vec3& direction) {
        const Vec3 t = computeTorques(direction, kCentre_m).value();
        return 0.4095 / std::max({std::fabs(t.x), std::fabs(t.y), std::fabs(t.z)});
    };
    EXPECT_NEAR(fullForce({0.0, 0.0, 1.0}), 16.9, 0.1);
    EXPECT_NEAR(std::min(fullForce({1.0, 0.0, 0.0}), fullForce({0.0, 1.0, 0.0})), 7.8, 0.2);
}

}  // namespace
}  // namespace stylet::haptics::falcon
