#include "patient/contrast/vessel_flow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/patient/contrast_phantom.h"

namespace stylet::patient {
namespace {

using test::addLabel;
using test::carve;
using test::liverBlock;

// A trunk along +x, in voxels of 1 mm. It runs through soft tissue, enters the liver at 40 mm and splits into
// two branches at 58 mm.
Package portalPhantom() {
    Package package = test::makeSlabs({{Tissue::soft, 0.040}, {Tissue::liver, 0.050}}, 0.001);
    const std::uint8_t portal =
        addLabel(package, "portal vein", Tissue::vessel, Role::risk, BloodKind::portal);
    carve(package, portal, [](double x, double y, double z) {
        const bool trunk = x > 0.005 && x < 0.060 && y * y + z * z < 0.004 * 0.004;
        const bool branches = std::abs(x - 0.058) < 0.0025 && std::abs(z) < 0.0025 && std::abs(y) < 0.017;
        return trunk || branches;
    });
    return package;
}

TEST(VesselFlow, FlowsThroughTheTrunkToTheHilumAndIntoTheBranches) {
    const test::OwnedPatient patient(portalPhantom());
    const VesselFlow flow = makeVesselFlow(patient);
    ASSERT_FALSE(flow.velocity.empty());
    for (const double x : {0.012, 0.025, 0.038, 0.048}) {
        const Vec3 v = flow.meanAt_m_per_s({x, 0.0, 0.0});
        EXPECT_GT(glm::normalize(v).x, 0.9) << x;
    }
    for (const double side : {-1.0, 1.0})
        EXPECT_GT(glm::normalize(flow.meanAt_m_per_s({0.058, side * 0.012, 0.0})).y * side, 0.9);
    EXPECT_EQ(flow.meanAt_m_per_s({0.020, 0.015, 0.0}), Vec3(0.0)) << "no blood beside it";
    EXPECT_EQ(flow.meanAt_m_per_s({9.0, 0.0, 0.0}), Vec3(0.0));
    EXPECT_EQ(flow.kindAt(flow.grid.nearest({0.025, 0.0, 0.0})), BloodKind::portal);
    EXPECT_EQ(flow.kindAt(flow.grid.nearest({0.025, 0.010, 0.0})), BloodKind::none);
}

TEST(VesselFlow, IsParabolicAcrossTheLumenAndSlowerInThinBranches) {
    const test::OwnedPatient patient(portalPhantom());
    const VesselFlow flow = makeVesselFlow(patient);
    const double trunk = VesselFlowSettings{}.trunk_m_per_s[std::size_t(BloodKind::portal)];
    double sum = 0.0, most = 0.0;
    int count = 0;
    const Index3 at = flow.grid.nearest({0.025, 0.0, 0.0});
    for (int y = -4; y <= 4; ++y)
        for (int z = -4; z <= 4; ++z) {
            const Vec3 p = flow.grid.centre(at + Index3(0, y, z));
            const double r = std::hypot(p.y, p.z), speed = glm::length(flow.meanAt_m_per_s(p));
            if (speed == 0.0) continue;
            EXPECT_NEAR(speed, 2.0 * trunk * (1.0 - r * r / (0.004 * 0.004)), 0.35 * trunk) << y << ' ' << z;
            sum += speed, most = std::max(most, speed), ++count;
        }
    EXPECT_NEAR(most, 2.0 * trunk, 0.1 * trunk);
    EXPECT_NEAR(sum / count, trunk, 0.25 * trunk) << "the mean of a paraboloid is half its maximum";
    EXPECT_LT(glm::length(flow.meanAt_m_per_s({0.058, 0.012, 0.0})), most);
}

TEST(VesselFlow, LeavesTheLiverThroughTheHepaticVeinsTowardTheCava) {
    Package package = liverBlock(0.080, 0.001);
    const std::uint8_t vein =
        addLabel(package, "hepatic veins", Tissue::vessel, Role::risk, BloodKind::hepatic);
    const std::uint8_t cava =
        addLabel(package, "vena cava and renal veins", Tissue::vessel, Role::risk, BloodKind::cava);
    const std::uint8_t aorta =
        addLabel(package, "aorta and arteries", Tissue::vessel, Role::risk, BloodKind::artery);
    carve(package, vein, test::tubeAlongX(0.010, 0.060, 0.0026));
    carve(package, cava,
          [](double x, double y, double) { return std::abs(x - 0.064) < 0.004 && std::abs(y) < 0.004; });
    carve(package, aorta, [](double x, double y, double) {
        return std::abs(x - 0.064) < 0.003 && std::abs(y - 0.012) < 0.003;
    });
    const Patient patient(package);
    const VesselFlow flow = makeVesselFlow(patient);
    EXPECT_GT(glm::normalize(flow.meanAt_m_per_s({0.020, 0.0, 0.0})).x, 0.9);
    EXPECT_GT(glm::normalize(flow.meanAt_m_per_s({0.050, 0.0, 0.0})).x, 0.9);
    EXPECT_GT(glm::normalize(flow.meanAt_m_per_s({0.064, 0.0, -0.005})).z, 0.9) << "toward the head";
    EXPECT_LT(glm::normalize(flow.meanAt_m_per_s({0.064, 0.012, -0.005})).z, -0.9) << "away from the heart";
}

TEST(VesselFlow, IsIndependentOfThreads) {
    const test::OwnedPatient patient(portalPhantom());
    const VesselFlow one = makeVesselFlow(patient, {}, 1);
    for (const int threads : {2, 5}) {
        const VesselFlow more = makeVesselFlow(patient, {}, threads);
        EXPECT_EQ(more.grid, one.grid);
        EXPECT_EQ(more.velocity, one.velocity);
    }
}

TEST(VesselFlow, IsEmptyWithoutVessels) {
    const test::OwnedPatient patient(liverBlock(0.020, 0.001));
    const VesselFlow flow = makeVesselFlow(patient);
    EXPECT_TRUE(flow.velocity.empty());
    EXPECT_EQ(flow.meanAt_m_per_s({0.01, 0.0, 0.0}), Vec3(0.0));
}

TEST(Pulse, HasMeanOneAndTheShapeOfEachVessel) {
    for (const BloodKind kind : {BloodKind::portal, BloodKind::hepatic, BloodKind::cava, BloodKind::artery}) {
        constexpr int kSteps = 1000;
        double sum = 0.0, low = 1e9, high = -1e9;
        for (int i = 0; i < kSteps; ++i) {
            const double now = pulse(kind, 7.0 + i / double(kSteps), 1.0);
            sum += now, low = std::min(low, now), high = std::max(high, now);
        }
        EXPECT_NEAR(sum / kSteps, 1.0, 0.005);
        EXPECT_EQ(high - low < 0.3, kind == BloodKind::portal);
        EXPECT_EQ(low < 0.0, kind == BloodKind::hepatic || kind == BloodKind::cava)
            << "the a wave flows backward";
        EXPECT_EQ(std::abs((high - low) / high - 0.7) < 0.01, kind == BloodKind::artery) << "resistive index";
    }
    EXPECT_EQ(pulse(BloodKind::artery, NAN), 1.0);
    EXPECT_EQ(pulse(BloodKind::artery, 1e300), 1.0);
}

}  // namespace
}  // namespace stylet::patient
