#include "haptics/tools/guide.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::haptics {
namespace {

// The rail points along the patient's +z. Its opening is at the origin.
struct Rail {
    GuideSettings settings;
    GuideState state;
    Pose patient_from_guide;
    bool free = true;

    GuideResult at(const Vec3& tip_m, const Quat& rotation = {1.0, 0.0, 0.0, 0.0}) {
        return stepGuide(state, settings, patient_from_guide, {rotation, tip_m}, free);
    }
    double acrossForce(double r_m, double z_m = 0.03) { return at({r_m, 0.0, z_m}).force_n.x; }
};

TEST(Guide, TheLineMeetsTheBeamsAxis) {
    const GuideSettings settings;
    const Vec3 in = settings.probe_from_guide.direction({0.0, 0.0, -1.0});
    const Vec3 mouth = settings.probe_from_guide.position_m;
    const Vec3 there = mouth - in * (mouth.x / in.x);
    EXPECT_NEAR(std::atan2(in.x, in.z), 25.0 * 3.14159265358979 / 180.0, 1e-12);
    EXPECT_NEAR(there.y, 0.0, 1e-15);
    EXPECT_NEAR(there.z, 0.0543, 1e-4);
}

TEST(Guide, FreeNeedleSnapsInPastTheForceMaximum) {
    Rail rail;
    EXPECT_EQ(rail.acrossForce(0.0070), 0.0);
    double last = 0.0;
    for (int um = 6000; um > 1500; um -= 10) {
        const double f = rail.acrossForce(1e-6 * um);
        ASSERT_LE(f, last) << um;  // toward the line, increasing
        last = f;
    }
    EXPECT_FALSE(rail.state.snapped);
    EXPECT_NEAR(last, -1.5, 0.01);
    const GuideResult in = rail.at({0.0015, 0.0, 0.03});
    EXPECT_TRUE(in.event);
    EXPECT_TRUE(rail.state.snapped);
    EXPECT_EQ(in.patient_from_needle.position_m, Vec3(0.0, 0.0, 0.03));
    EXPECT_NEAR(in.force_n.x, -1.5, 1e-12);
    EXPECT_FALSE(rail.at({0.001, 0.0, 0.03}).event);
    EXPECT_NEAR(rail.acrossForce(0.0005), -0.5, 1e-12);
}

// The force is the gradient of the energy, snapped in or not. Snapping in adds no energy.
// HZ-FORCE-09
TEST(Guide, RailIsPassive) {
    for (const bool snapped : {false, true}) {
        Rail rail;
        rail.settings.release_n = 1e9;
        const double h = 1e-7;
        for (const double r : {0.0004, 0.0014, 0.0016, 0.003, 0.0055, 0.0065}) {
            const auto energy = [&](double x) {
                rail.state.snapped = snapped;
                rail.settings.catch_cosine = snapped ? -1.0 : 2.0;  // never snaps in
                return rail.at({x, 0.0, 0.03}).energy_j;
            };
            const double slope = (energy(r + h) - energy(r - h)) / (2.0 * h);
            rail.state.snapped = snapped;
            EXPECT_NEAR(rail.acrossForce(r), -slope, 1e-5) << r;
        }
    }
    Rail rail;
    const double before_j = rail.at({0.0015 + 1e-12, 0.0, 0.03}).energy_j;
    EXPECT_FALSE(rail.state.snapped);
    EXPECT_NEAR(rail.at({0.0015, 0.0, 0.03}).energy_j, before_j, 1e-11);
    EXPECT_TRUE(rail.state.snapped);
}

// No force means no stored energy: a needle that passes the rail's ends at a distance adds none.
TEST(Guide, FarFromTheLineThereIsNoEnergy) {
    for (const double z_m : {-0.1, -0.005, -1e-6, 1e-6, 0.03, 0.06 - 1e-6, 0.06 + 1e-6, 0.065, 0.2}) {
        Rail rail;
        const GuideResult far = rail.at({0.3, 0.0, z_m});
        EXPECT_EQ(far.energy_j, 0.0) << z_m;
        EXPECT_EQ(far.force_n, Vec3(0.0)) << z_m;
    }
}

TEST(Guide, ForceAtTheRailEndsIsTheEnergyGradient) {
    for (const double r : {0.0016, 0.003, 0.0055}) {
        Rail rail;
        rail.settings.catch_cosine = 2.0;  // never snaps in
        Vec3 last = rail.at({r, 0.0, -0.02}).force_n;
        EXPECT_EQ(last, Vec3(0.0));
        for (int i = -1999; i <= 8000; ++i) {
            const double z = 1e-5 * i, h = 1e-7;
            const GuideResult here = rail.at({r, 0.0, z});
            EXPECT_FALSE(here.event);
            ASSERT_LT(glm::length(here.force_n - last), 0.005) << z;
            if (i % 50 == 0) {
                const double slope =
                    (rail.at({r, 0.0, z + h}).energy_j - rail.at({r, 0.0, z - h}).energy_j) / (2.0 * h);
                EXPECT_NEAR(here.force_n.z, -slope, 1e-3) << z;
            }
            last = here.force_n;
        }
        EXPECT_EQ(last, Vec3(0.0));
    }
}

// The rail releases a needle that enters the body beside it, and guides it again after withdrawal. Both are
// events.
TEST(Guide, EnteringOrLeavingTheBodyNearTheRailIsAnEvent) {
    Rail rail;
    rail.acrossForce(0.003);
    rail.free = false;
    const GuideResult in = rail.at({0.003, 0.0, 0.03});
    EXPECT_EQ(in.force_n, Vec3(0.0));
    EXPECT_TRUE(in.event);
    EXPECT_FALSE(rail.at({0.003, 0.0, 0.03}).event);
    rail.free = true;
    EXPECT_TRUE(rail.at({0.003, 0.0, 0.03}).event);
    rail.at({0.007, 0.0, 0.03});
    rail.free = false;
    EXPECT_FALSE(rail.at({0.007, 0.0, 0.03}).event);  // there was no force there
}

TEST(Guide, SnapsInOnlyAlongItsLengthAndFreeAndAligned) {
    const double half = 0.5 * 25.0 * 3.14159265358979 / 180.0;
    const Quat tilted{std::cos(half), std::sin(half), 0.0, 0.0};
    Rail rail;
    rail.at({0.0, 0.0, -0.001});
    rail.at({0.0, 0.0, 0.061});
    rail.at({0.0, 0.0, 0.03}, tilted);
    rail.free = false;
    rail.at({0.0, 0.0, 0.03});
    EXPECT_FALSE(rail.state.snapped);
    rail.free = true;
    rail.at({0.0, 0.0, 0.03});
    EXPECT_TRUE(rail.state.snapped);
}

TEST(Guide, KeepsTheNeedleOnTheLineUntilWithdrawnOrPulledOut) {
    Rail rail;
    rail.at({0.0, 0.0, 0.05});
    rail.free = false;  // in the body
    const GuideResult deep = rail.at({0.020, 0.0, -0.080});
    EXPECT_TRUE(rail.state.snapped);
    EXPECT_EQ(deep.patient_from_needle.position_m, Vec3(0.0, 0.0, -0.080));
    EXPECT_NEAR(deep.force_n.x, -20.0, 1e-9);
    EXPECT_EQ(deep.force_n.z, 0.0);
    rail.free = true;
    EXPECT_FALSE(rail.at({0.0059, 0.0, 0.01}).event);
    EXPECT_TRUE(rail.at({0.0061, 0.0, 0.01}).event);
    EXPECT_FALSE(rail.state.snapped);
    rail.at({0.0, 0.0, 0.05});
    EXPECT_TRUE(rail.at({0.0, 0.0, 0.0601}).event);
    EXPECT_FALSE(rail.state.snapped);
}

}  // namespace
}  // namespace stylet::haptics
