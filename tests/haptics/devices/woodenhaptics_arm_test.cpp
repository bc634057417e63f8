#include "haptics/devices/woodenhaptics/woodenhaptics_arm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/haptics/devices/wooden_json.h"

namespace stylet::haptics {
namespace {

using test::woodenJson;

WoodenModel arm() {
    return parseWoodenModel(woodenJson(), "arm.json");
}

WoodenModel armWithWrist() {
    WoodenModel m = arm();
    m.counts_per_turn = {2000, 2000, 2000, 1024, 1024, 1024};
    return m;
}

Vec3 randomAngles(std::mt19937& random) {
    std::uniform_real_distribution<double> side(-1.2, 1.2), up(-0.6, 1.0), out(0.4, 2.4);
    return {side(random), up(random), out(random)};
}

TEST(WoodenArm, AnglesFollowCapstansAndDirections) {
    // 2000 counts are one turn of the motor, which turns the body by the ratio of capstan and body
    // diameter.
    const Vec3 t = armAngles_rad(arm(), {2000, 2000, -500, 0, 0, 0});
    EXPECT_NEAR(t.x, 2.0 * std::numbers::pi * 0.010 / 0.160, 1e-12);
    EXPECT_NEAR(t.y, -2.0 * std::numbers::pi * 0.011 / 0.120, 1e-12) << "motor and body are aligned";
    EXPECT_NEAR(t.z, -0.5 * std::numbers::pi * 0.012 / 0.125, 1e-12);
}

TEST(WoodenArm, PositionsInClosedForm) {
    const WoodenModel m = arm();
    // Upper arm up, forearm straight out.
    const Vec3 rest = armPosition_m(m, {0.0, 0.0, std::numbers::pi / 2});
    EXPECT_NEAR(rest.x, 0.245 - 0.220, 1e-12);
    EXPECT_NEAR(rest.y, 0.0, 1e-12);
    EXPECT_NEAR(rest.z, 0.080 + 0.205 - 0.080, 1e-12);
    // A quarter turn: to the user's right.
    const Vec3 turned = armPosition_m(m, {std::numbers::pi / 2, 0.0, std::numbers::pi / 2});
    EXPECT_NEAR(turned.x, -0.220, 1e-12);
    EXPECT_NEAR(turned.y, 0.245, 1e-12);
    // Upper arm out, forearm down.
    const Vec3 low = armPosition_m(m, {0.0, std::numbers::pi / 2, 0.0});
    EXPECT_NEAR(low.x, 0.205 - 0.220, 1e-12);
    EXPECT_NEAR(low.z, 0.080 - 0.245 - 0.080, 1e-12);
}

// HZ-FORCE-10
TEST(WoodenArm, TheJacobianIsThePositionsDerivative) {
    const WoodenModel m = arm();
    std::mt19937 random(5);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 t = randomAngles(random);
        const glm::dmat3 jacobian = armJacobian(m, t);
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 more = t, less = t;
            more[axis] += kStep, less[axis] -= kStep;
            const Vec3 by_differences = (armPosition_m(m, more) - armPosition_m(m, less)) / (2.0 * kStep);
            const Vec3 wrong = jacobian[axis] - by_differences;
            ASSERT_LT(std::sqrt(glm::dot(wrong, wrong)), 1e-9) << "axis " << axis;
        }
    }
}

// The potential energy of the weight, computed independently.
double potential_j(const WoodenModel& m, const Vec3& t) {
    const double z_b = m.length_m[0] + m.centre_of_mass_m[0] * std::cos(t.y);
    const double z_c = m.length_m[0] + m.length_m[1] * std::cos(t.y) - m.centre_of_mass_m[1] * std::cos(t.z);
    return 9.81 * (m.mass_kg[0] * z_b + m.mass_kg[1] * z_c);
}

TEST(WoodenArm, GravityTorqueIsThePotentialsDerivative) {
    const WoodenModel m = arm();
    std::mt19937 random(6);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 500; ++i) {
        const Vec3 t = randomAngles(random);
        const Vec3 torque = armGravityTorque_n_m(m, t);
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 more = t, less = t;
            more[axis] += kStep, less[axis] -= kStep;
            ASSERT_NEAR(torque[axis], (potential_j(m, more) - potential_j(m, less)) / (2.0 * kStep), 1e-8);
        }
    }
    WoodenModel off = m;
    off.gravity_m_s2 = 0.0;
    EXPECT_EQ(armCurrents(off, {0.3, 0.4, 1.5}, Vec3{0.0}).motor_a, Vec3(0.0));
}

// Force at the grip for given motor currents, from virtual work. Excludes the gravity compensation.
Vec3 forceOf(const WoodenModel& m, const Vec3& t, const Vec3& motor_a) {
    const Vec3 hold = armGravityTorque_n_m(m, t);
    Vec3 torque;
    for (int i = 0; i < 3; ++i) {
        const std::size_t k = std::size_t(i);
        const double direction = m.motor_aligned[k] ? -1.0 : 1.0;
        torque[i] = motor_a[i] * m.torque_constant_n_m_per_a[k] * direction * m.body_diameter_m[k] /
                        m.capstan_diameter_m[k] -
                    hold[i];
    }
    return glm::inverse(glm::transpose(armJacobian(m, t))) * torque;
}

// HZ-FORCE-10
TEST(WoodenArm, CurrentsProduceTheCommandedForce) {
    const WoodenModel m = arm();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> newtons(-1.5, 1.5);
    int whole = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3 t{std::uniform_real_distribution<double>(-1, 1)(random),
                     std::uniform_real_distribution<double>(-0.2, 0.6)(random),
                     std::uniform_real_distribution<double>(1.0, 2.0)(random)};
        const Vec3 force{newtons(random), newtons(random), newtons(random)};
        const ArmCurrents currents = armCurrents(m, t, force);
        if (currents.limited) continue;
        const Vec3 wrong = forceOf(m, t, currents.motor_a) - force;
        EXPECT_LT(std::sqrt(glm::dot(wrong, wrong)), 1e-9);
        ++whole;
    }
    EXPECT_GT(whole, 100);
}

// HZ-FORCE-01
TEST(WoodenArm, ALimitedForceKeepsItsDirection) {
    const WoodenModel m = arm();
    std::mt19937 random(8);
    std::uniform_real_distribution<double> newtons(-60.0, 60.0);
    int limited = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 t{0.2, std::uniform_real_distribution<double>(-0.2, 0.6)(random), 1.5};
        const Vec3 force{newtons(random), newtons(random), newtons(random)};
        const ArmCurrents currents = armCurrents(m, t, force);
        for (int axis = 0; axis < 3; ++axis)
            ASSERT_LE(std::fabs(currents.motor_a[axis]), kMaxCurrent_a);
        if (!currents.limited) continue;
        ++limited;
        const Vec3 made = forceOf(m, t, currents.motor_a);
        const double cosine =
            glm::dot(made, force) / std::sqrt(glm::dot(made, made) * glm::dot(force, force));
        ASSERT_GT(cosine, 1.0 - 1e-9);
        ASSERT_LT(glm::dot(made, made), glm::dot(force, force));
    }
    EXPECT_GT(limited, 1000);
}

// HZ-FORCE-03
TEST(WoodenArm, NonFiniteForceCountsAsZero) {
    const WoodenModel m = arm();
    const Vec3 t{0.1, 0.2, 1.4};
    for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY)})
        EXPECT_EQ(armCurrents(m, t, {0.0, bad, 1.0}).motor_a, armCurrents(m, t, Vec3{0.0}).motor_a);
}

TEST(WoodenArm, TheWristTurnsTheStylus) {
    const WoodenModel m = armWithWrist();
    const Vec3 level{0.0, 0.0, std::numbers::pi / 2};
    EXPECT_EQ(armRotation(arm(), level, {1, 2, 3, 4, 5, 6}), Quat(1.0, 0.0, 0.0, 0.0));
    const auto along = [&](const Vec3& t, const ArmCounts& counts) {
        return armRotation(m, t, counts) * Vec3{1.0, 0.0, 0.0};
    };
    const auto expectNear = [](const Vec3& a, const Vec3& b) {
        EXPECT_LT(std::sqrt(glm::dot(a - b, a - b)), 1e-12) << a.x << " " << a.y << " " << a.z;
    };
    expectNear(along(level, {}), {1.0, 0.0, 0.0});
    // The stylus follows the forearm's pitch and the arm's turn.
    expectNear(along({0.0, 0.0, std::numbers::pi / 2 + 0.3}, {}), {std::cos(0.3), 0.0, std::sin(0.3)});
    expectNear(along({std::numbers::pi / 2, 0.0, std::numbers::pi / 2}, {}), {0.0, 1.0, 0.0});
    // Encoder e pitches the middle body and counts in its direction. The outer bodies roll.
    expectNear(along(level, {0, 0, 0, 100, 256, 0}), {0.0, 0.0, -1.0});
    expectNear(along(level, {0, 0, 0, 100, 0, 77}), {1.0, 0.0, 0.0});
    // After a quarter roll against the counting direction, the same pitch points sideways.
    expectNear(along(level, {0, 0, 0, 0, 256, -256}), {0.0, 1.0, 0.0});
}

TEST(WoodenArm, ResolutionMatchesOneEncoderCount) {
    const WoodenModel m = arm();
    const Vec3 t{0.0, 0.1, 1.5};
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        ArmCounts one{};
        one[i] = 1;
        const Vec3 step = armPosition_m(m, t + armAngles_rad(m, one)) - armPosition_m(m, t);
        sum += glm::dot(step, step);
    }
    EXPECT_NEAR(armResolution_m(m, t), std::sqrt(sum), 1e-8);
    EXPECT_GT(armResolution_m(m, t), 5e-5);
    EXPECT_LT(armResolution_m(m, t), 2e-4);
}

}  // namespace
}  // namespace stylet::haptics
