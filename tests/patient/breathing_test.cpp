#include "patient/breathing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stylet::patient {
namespace {

// A torso's worth of motion: 20 mm caudal at inhale, falling off over 50 mm.
BreathingModel torso() {
    BreathingModel m;
    m.a1_m = -0.020;
    m.a2_m_s = 0.002;
    m.outside_share = 0.2;
    m.z_low_m = -0.15, m.z_full_low_m = -0.08, m.z_full_high_m = 0.06, m.z_high_m = 0.11;
    m.cavity = {{-0.16, 0, 0.01, 0.13, 0.10},
                {-0.05, 0, 0, 0.14, 0.10},
                {0.05, 0.005, 0, 0.12, 0.09},
                {0.12, 0, 0, 0.03, 0.03}};
    return m;
}

const std::vector<Surrogate> kBreaths = {{0.0, 0.0}, {0.3, 1.2}, {1.0, 0.0}, {0.6, -1.5}, {1.2, 0.5}};

TEST(BreathingMotion, RigidWhereTheBumpIsFull) {
    const BreathingModel m = torso();
    const Vec3 p{0.0, 0.0, 0.0};
    EXPECT_NEAR(deformedFromReference(m, {1.0, 0.0}, p).z, -0.020, 1e-15);
    EXPECT_NEAR(deformedFromReference(m, {0.5, 1.0}, p).z, -0.010 + 0.002, 1e-15);
}

TEST(BreathingMotion, IsRelativeToTheBreathOfTheCt) {
    BreathingModel m = torso();
    m.reference = {1.0, 0.0};
    const Vec3 p{0.01, 0.02, 0.0};
    EXPECT_EQ(deformedFromReference(m, m.reference, p), p);
    EXPECT_EQ(referenceFromDeformed(m, m.reference, p), p);
    EXPECT_NEAR(deformedFromReference(m, {0.0, 0.0}, p).z, 0.020, 1e-15);
}

TEST(BreathingMotion, InverseBringsEveryPointBack) {
    const BreathingModel m = torso();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(-0.2, 0.2);
    for (const Surrogate& breath : kBreaths) {
        double worst_m = 0.0;
        for (int i = 0; i < 20000; ++i) {
            const Vec3 p{u(random), u(random), u(random)};
            const Vec3 back = referenceFromDeformed(m, breath, deformedFromReference(m, breath, p));
            worst_m = std::max(worst_m, glm::length(back - p));
        }
        EXPECT_LT(worst_m, 0.0001) << breath.v;
    }
}

TEST(BreathingMotion, NeverFoldsAndKeepsItsSide) {
    const BreathingModel m = torso();
    constexpr double h = 1e-6;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(-0.2, 0.2);
    for (const Surrogate& breath : kBreaths)
        for (int i = 0; i < 5000; ++i) {
            const Vec3 p{u(random), u(random), u(random)};
            const double rho = cavityRho(m, p);
            if (std::abs(rho - 1.0) < 1e-3) continue;
            const Vec3 q = deformedFromReference(m, breath, p);
            if (std::isfinite(rho)) {
                EXPECT_NEAR(cavityRho(m, q), rho, 1e-9);
            }
            const Vec3 dx = (deformedFromReference(m, breath, p + Vec3(h, 0, 0)) - q) / h;
            const Vec3 dy = (deformedFromReference(m, breath, p + Vec3(0, h, 0)) - q) / h;
            const Vec3 dz = (deformedFromReference(m, breath, p + Vec3(0, 0, h)) - q) / h;
            EXPECT_GT(glm::dot(glm::cross(dx, dy), dz), 0.05);
        }
}

TEST(BreathingMotion, SlipsAcrossTheInterface) {
    BreathingModel m = torso();
    m.cavity = {{-0.16, 0, 0, 0.1, 0.1}, {0.12, 0, 0, 0.1, 0.1}};
    const Surrogate inhale{1.0, 0.0};
    EXPECT_NEAR(deformedFromReference(m, inhale, {0.0999999, 0, 0}).z, -0.020, 1e-12);
    EXPECT_NEAR(deformedFromReference(m, inhale, {0.1000001, 0, 0}).z, -0.004, 1e-9);
    EXPECT_EQ(deformedFromReference(m, inhale, {0.17, 0, 0}), Vec3(0.17, 0, 0));
}

TEST(BreathingMotion, NothingMovesBeyondTheBumpOrWithoutACavity) {
    BreathingModel m = torso();
    for (const double z : {-0.15, -0.3, 0.11, 0.5}) {
        const Vec3 p{0.01, 0.01, z};
        EXPECT_EQ(deformedFromReference(m, {1.0, 0.0}, p), p);
    }
    m.cavity.clear();
    EXPECT_EQ(deformedFromReference(m, {1.0, 0.0}, Vec3(0.0)), Vec3(0.0));
    EXPECT_TRUE(std::isinf(cavityRho(m, Vec3(0.0))));
}

// What a picture makes of the table.
Vec3 fromTable(const BreathingModel& m, const BreathingTable& t, const Vec3& p) {
    const double at = (p.z - t.z_begin_m) / t.dz_m;
    const auto i = std::size_t(std::floor(at));
    if (at < 0.0 || i + 1 >= t.inside_reference_z_m.size()) return p;
    const double rho = cavityRho(m, p), s = at - double(i);
    const std::vector<float>& side = rho < 1.0 ? t.inside_reference_z_m : t.outside_reference_z_m;
    const double table_z = (1 - s) * double(side[i]) + s * double(side[i + 1]);
    const double z = rho < 1.0 ? table_z : p.z + outsideFade(m, rho) * (table_z - p.z);
    return {p.x, p.y, z};
}

TEST(BreathingTable, AgreesWithThePointVersion) {
    const BreathingModel m = torso();
    std::mt19937 random(5);
    std::uniform_real_distribution<double> u(-0.2, 0.2);
    for (const Surrogate& breath : kBreaths) {
        const BreathingTable table = breathingTable(m, breath, 256);
        if (breath == m.reference) {
            EXPECT_TRUE(table.inside_reference_z_m.empty());
            continue;
        }
        ASSERT_EQ(table.inside_reference_z_m.size(), 256u);
        for (int i = 0; i < 20000; ++i) {
            const Vec3 p{u(random), u(random), u(random)};
            ASSERT_NEAR(fromTable(m, table, p).z, referenceFromDeformed(m, breath, p).z, 0.0001);
        }
    }
}

}  // namespace
}  // namespace stylet::patient
