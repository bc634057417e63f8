#include "haptics/tools/touch.h"

#include <gtest/gtest.h>

#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using patient::Tissue;
using enum patient::Tissue;

constexpr double kStiffest_n_per_m3 = 1e7;

Layers layersOf(const std::vector<std::pair<Tissue, double>>& slabs) {
    const patient::Package package = test::makeSlabs(slabs, 0.001);
    return computeLayers(patient::Patient(package), Vec3(0.0), {1.0, 0.0, 0.0});
}

double young(Tissue t) {
    return test::tissueDefaults().elasticity[std::size_t(t)].young_pa;
}

TEST(Layers, AreSpringsInSeriesDownToFortyMillimetres) {
    const Layers l = layersOf({{skin, 0.002}, {soft, 0.020}, {fascia, 0.001}, {liver, 0.050}});
    EXPECT_NEAR(l.compliance_m_per_pa,
                0.002 / young(skin) + 0.020 / young(soft) + 0.001 / young(fascia) + 0.017 / young(liver),
                1e-15);
    EXPECT_TRUE(std::isinf(l.cover_m));
}

TEST(Layers, EndAtBone) {
    const Layers l = layersOf({{skin, 0.002}, {soft, 0.009}, {bone, 0.008}, {liver, 0.030}});
    EXPECT_NEAR(l.compliance_m_per_pa, 0.002 / young(skin) + 0.009 / young(soft), 1e-15);
    EXPECT_NEAR(l.cover_m, 0.011, 1e-12);
    EXPECT_EQ(layersOf({{bone, 0.030}}).compliance_m_per_pa, 0.0);
    EXPECT_EQ(layersOf({{bone, 0.030}}).cover_m, 0.0);
}

TEST(Layers, GasIsCompliantAndOuterAirIsIgnored) {
    // Unlabelled air behind tissue is gas, and yields according to the row of air in the table.
    const Layers l = layersOf({{soft, 0.010}, {air, 0.010}, {soft, 0.040}});
    EXPECT_NEAR(l.compliance_m_per_pa, 0.030 / young(soft) + 0.010 / young(air), 1e-15);
    const patient::Package package = test::makeSlabs({{soft, 0.060}}, 0.001);
    for (const double off_m : {-0.0015, 0.0, 0.0015}) {
        const Layers shifted = computeLayers(patient::Patient(package), {off_m, 0.0, 0.0}, {1.0, 0.0, 0.0});
        EXPECT_NEAR(shifted.compliance_m_per_pa, 0.040 / young(soft), 1e-15) << off_m;
    }
}

TEST(TouchMap, StoresTheLayersAndTheirGradient) {
    const patient::Package package = test::makeSlabs({{skin, 0.002}, {soft, 0.010}, {bone, 0.010}}, 0.001);
    const patient::Patient patient(package);
    const TouchMap map = makeTouchMap(patient, makeSkin(patient, 1), 1);
    const double compliance = 0.002 / young(skin) + 0.010 / young(soft);
    for (const double depth_m : {-0.001, 0.001, 0.006, 0.012}) {
        const TouchPoint t = touchAt(map, {depth_m, 0.002, -0.003});
        EXPECT_NEAR(t.level_m, -depth_m, 1e-6);
        EXPECT_NEAR(t.stiffness_n_per_m3 * compliance, 1.0, 1e-5);
        EXPECT_NEAR(t.bone_per_m * 0.012, 1.0, 1e-5);
        EXPECT_NEAR(glm::length(t.level_slope - Vec3(-1.0, 0.0, 0.0)), 0.0, 1e-5);
    }
    const TouchMap threaded = makeTouchMap(patient, makeSkin(patient, 1), 3);
    EXPECT_EQ(map.nodes, threaded.nodes);
}

// A hand without force feedback, or with a weak device, presses deeper than the nodes reach.
TEST(TouchMap, ContinuesItsLayersBelowTheDeepestNodes) {
    const patient::Package package = test::makeSlabs({{skin, 0.002}, {soft, 0.098}}, 0.001);
    const patient::Patient patient(package);
    const TouchMap map = makeTouchMap(patient, makeSkin(patient, 1), 1);
    const double stiffness = 1.0 / (0.002 / young(skin) + 0.038 / young(soft));
    for (int depth_mm = 40; depth_mm <= 80; ++depth_mm) {
        const double depth_m = 0.001 * depth_mm;
        const SkinPressure p = computePressure(touchAt(map, {depth_m, 0.002, -0.003}), kStiffest_n_per_m3);
        EXPECT_NEAR(p.pressure_pa / (stiffness * depth_m), 1.0, 1e-4) << depth_mm;
        EXPECT_NEAR(-p.push_n_per_m2.x / p.pressure_pa, 1.0, 1e-3) << depth_mm;
        const double beyond = touchAt(map, {depth_m, 0.040, -0.003}).stiffness_n_per_m3;
        EXPECT_NEAR(beyond / stiffness, 1.0, 1e-4) << depth_mm << ", beyond the image's edge";
    }
}

// A point with gradients in all three quantities.
TouchPoint pointAt(const Vec3& p) {
    TouchPoint t;
    t.level_slope = {-0.9, 0.1, 0.05};
    t.stiffness_slope = {2e5, 3e6, -1e6};
    t.bone_slope = {50.0, -400.0, 300.0};
    t.level_m = glm::dot(t.level_slope, p);
    t.stiffness_n_per_m3 = 4e5 + glm::dot(t.stiffness_slope, p);
    t.bone_per_m = 80.0 + glm::dot(t.bone_slope, p);
    return t;
}

TEST(SkinPressure, IsTheGradientOfOnePotential) {
    constexpr double kStep_m = 1e-7;
    for (const double depth_m : {0.0005, 0.003, 0.0062, 0.008, 0.015}) {
        const Vec3 p{depth_m, 0.001, -0.002};
        const SkinPressure here = computePressure(pointAt(p), kStiffest_n_per_m3);
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 high = p, low = p;
            high[axis] += kStep_m, low[axis] -= kStep_m;
            const double slope = (computePressure(pointAt(high), kStiffest_n_per_m3).energy_j_per_m2 -
                                  computePressure(pointAt(low), kStiffest_n_per_m3).energy_j_per_m2) /
                                 (2.0 * kStep_m);
            EXPECT_NEAR(here.push_n_per_m2[axis], -slope, 1e-4 * here.pressure_pa) << depth_m << " " << axis;
        }
    }
    EXPECT_EQ(computePressure(pointAt({-0.001, 0.0, 0.0}), kStiffest_n_per_m3).pressure_pa, 0.0);
}

TEST(SkinPressure, IsLinearWithoutBone) {
    TouchPoint t;
    t.stiffness_n_per_m3 = 2e5;
    for (const double depth_m : {0.001, 0.020, 0.040}) {
        t.level_m = -depth_m;
        EXPECT_DOUBLE_EQ(computePressure(t, kStiffest_n_per_m3).pressure_pa, 2e5 * depth_m);
        EXPECT_DOUBLE_EQ(computePressure(t, kStiffest_n_per_m3).energy_j_per_m2, 1e5 * depth_m * depth_m);
    }
}

TEST(SkinPressure, StiffensOverBoneUpToItsStiffness) {
    for (const double stiffness : {1e5, 1.2e6, 1e8})
        for (const double cover_m : {0.0005, 0.012, 0.040}) {
            TouchPoint t;
            t.stiffness_n_per_m3 = stiffness;
            t.bone_per_m = 1.0 / cover_m;
            double before_pa = 0.0;
            constexpr double kStep_m = 1e-5;
            for (int i = 1; i < 5000; ++i) {
                t.level_m = -i * kStep_m;
                const double pressure_pa = computePressure(t, kStiffest_n_per_m3).pressure_pa;
                const double tangent = (pressure_pa - before_pa) / kStep_m;
                ASSERT_GT(tangent, 0.0);
                ASSERT_LE(tangent, kStiffest_n_per_m3 * (1.0 + 1e-9))
                    << stiffness << " " << cover_m << " " << i;
                before_pa = pressure_pa;
            }
        }
    // Compressed by half: the tangent is 8 k and the pressure 1.5 k h, with stiffness k and cover h.
    TouchPoint t;
    t.stiffness_n_per_m3 = 3e5, t.bone_per_m = 1.0 / 0.012, t.level_m = -0.006;
    EXPECT_NEAR(computePressure(t, kStiffest_n_per_m3).pressure_pa, 1.5 * 3e5 * 0.012, 1e-6);
}

}  // namespace
}  // namespace stylet::haptics
