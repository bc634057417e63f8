#include "haptics/tools/scalpel.h"

#include <gtest/gtest.h>

#include "tests/haptics/along_x.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using patient::Surrogate;
using test::kAlongX;
using enum patient::Tissue;

// The cutting edge faces +z.
struct ScalpelBench {
    explicit ScalpelBench(std::vector<std::pair<patient::Tissue, double>> slabs = {{skin, 0.002},
                                                                                   {soft, 0.058}})
        : package(test::makeSlabs(slabs, 0.001)) {}

    ToolForce to(double depth_m, double z_m = 0.0) {
        at_m = {depth_m, 0.0, z_m};
        force = stepScalpel(state, incisions, settings, {map, package.motion, breath}, {kAlongX, at_m});
        events += force.event;
        return force;
    }
    void sweep(double depth_m, double z_m) {
        const Vec3 from = at_m, way = Vec3(depth_m, 0.0, z_m) - from;
        const int steps = 1 + int(glm::length(way) / 2e-5);
        for (int i = 1; i <= steps; ++i)
            to(from.x + way.x * i / steps, from.z + way.z * i / steps);
    }
    double opened() const {
        const Incision& cut = incisions.list[0];
        return glm::length(cut.end_reference_m - cut.begin_reference_m);
    }

    patient::Package package;
    patient::Patient patient{package};
    TouchMap map = makeTouchMap(patient, makeSkin(patient, 2), 2);
    ScalpelSettings settings;
    ScalpelState state;
    Incisions incisions;
    Surrogate breath;
    Vec3 at_m{-0.001, 0.0, 0.0};
    ToolForce force;
    int events = 0;
};

TEST(Scalpel, TouchesLightlyThenCuts) {
    ScalpelBench s;
    s.to(-0.001);
    s.events = 0;
    const double at_m = s.settings.cut_force_n / s.settings.stiffness_n_per_m;  // 0.5 mm
    s.sweep(0.98 * at_m, 0.0);
    EXPECT_NEAR(-s.force.force_n.x / (0.98 * s.settings.cut_force_n), 1.0, 1e-3);
    EXPECT_NEAR(s.force.energy_j, 0.5 * 800.0 * 0.98 * at_m * 0.98 * at_m, 1e-7);
    EXPECT_EQ(s.incisions.count, 0);
    EXPECT_EQ(s.events, 0);
    s.sweep(1.02 * at_m, 0.0);
    EXPECT_EQ(s.incisions.count, 1);
    EXPECT_EQ(s.events, 1);
    EXPECT_NEAR(-s.force.force_n.x, s.settings.deeper_n, 1e-3);
    // Lifted before it cuts, the scalpel leaves the skin intact.
    ScalpelBench light;
    light.sweep(0.9 * at_m, 0.0);
    light.sweep(0.9 * at_m, 0.010);
    light.sweep(-0.001, 0.010);
    EXPECT_EQ(light.incisions.count, 0);
}

TEST(Scalpel, StabOpensTheBladeWidth) {
    ScalpelBench s;
    s.sweep(0.006, 0.0);
    EXPECT_NEAR(s.opened(), s.settings.width_per_depth * 0.006, 1e-4);
    EXPECT_NEAR(-s.force.force_n.x, s.settings.deeper_n, 1e-3);
    EXPECT_TRUE(isOpen(s.incisions, {0.0, 0.0, 0.003}, 0.0015));
    EXPECT_FALSE(isOpen(s.incisions, {0.0, 0.0, 0.006}, 0.0015));
    EXPECT_FALSE(isOpen(s.incisions, {0.0, 0.0, -0.002}, 0.0015));
}

TEST(Scalpel, DrawnBladeOpensItsPath) {
    ScalpelBench s;
    s.sweep(0.003, 0.0);
    s.sweep(0.003, 0.008);
    EXPECT_EQ(s.incisions.count, 1);
    EXPECT_NEAR(s.opened(), 0.008 + s.settings.width_per_depth * 0.003, 2e-4);
    EXPECT_NEAR(-s.force.force_n.z, s.settings.along_edge_n, 1e-3);
    // Out, and in again through the incision: no threshold and no second incision.
    s.sweep(-0.001, 0.008);
    EXPECT_EQ(s.force.force_n, Vec3(0.0));
    s.events = 0;
    s.sweep(0.0003, 0.004);
    EXPECT_LE(-s.force.force_n.x, s.settings.deeper_n + 1e-9);
    EXPECT_EQ(s.events, 1);
    EXPECT_EQ(s.incisions.count, 1);
}

// Tissue holds the blade until its point is out. That step in force must be reported as an event.
TEST(Scalpel, LeavingTheSkinIsAnEventWhereTheForceSteps) {
    for (const double beside_m : {0.0, 0.004}) {
        ScalpelBench s;
        s.sweep(0.003, 0.0);
        Vec3 before_n = s.force.force_n;
        double most_n = 0.0;
        for (int i = 1; i <= 200; ++i) {
            const ToolForce f = s.to(0.003 - 2e-5 * i, beside_m * i / 200.0);
            const double step_n = glm::length(f.force_n - before_n);
            // Step of the spring itself: 800 N/m over at most 28 um.
            EXPECT_TRUE(step_n <= 0.03 || f.event) << i;
            most_n = std::max(most_n, step_n);
            before_n = f.force_n;
        }
        EXPECT_GT(most_n, 0.2);
        EXPECT_EQ(before_n, Vec3(0.0));
    }
}

TEST(Scalpel, DoesNotCutBone) {
    ScalpelBench s({{skin, 0.002}, {soft, 0.004}, {bone, 0.010}});
    s.sweep(0.009, 0.0);  // 3 mm behind the bone's surface
    EXPECT_GT(-s.force.force_n.x, 0.9 * 0.0029 * s.settings.stiffness_n_per_m);
}

TEST(Scalpel, ReturnsNoMoreEnergyThanItReceives) {
    ScalpelBench s;
    s.package.motion = test::makeShift(-0.010);
    double stored_j = 0.0, shortfall_j = 0.0, moved_j = 0.0;
    Vec3 before_m = s.at_m;
    for (int i = 0; i < 20000; ++i) {
        s.breath.v = 0.5 + 0.5 * std::sin(0.002 * i);
        const ToolForce f = s.to(0.001 + 0.003 * std::sin(0.003 * i), 0.006 * std::sin(0.0011 * i));
        const double put_in_j = -glm::dot(f.force_n, s.at_m - before_m - f.tissue_moved_m);
        // Energy released by a cut is an event. The spring relaxes and does no work on the hand.
        if (!f.event) shortfall_j += std::max(0.0, f.energy_j - stored_j - put_in_j);
        moved_j += std::fabs(put_in_j);
        stored_j = f.energy_j;
        before_m = s.at_m;
    }
    EXPECT_GT(moved_j, 0.005);
    EXPECT_LT(shortfall_j, 0.01 * moved_j);
}

TEST(Scalpel, FullListAddsNoIncision) {
    ScalpelBench s;
    for (int i = 0; i < kMaxIncisions + 2; ++i) {
        s.sweep(-0.001, -0.017 + 0.0035 * i);
        s.sweep(0.001, -0.017 + 0.0035 * i);
    }
    EXPECT_EQ(s.incisions.count, kMaxIncisions);
    EXPECT_TRUE(s.state.cutting);
}

}  // namespace
}  // namespace stylet::haptics
