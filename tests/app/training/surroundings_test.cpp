#include "app/training/surroundings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/app/training/wall.h"

namespace stylet::training {
namespace {

// Borders at whole millimetres: the vessel from 32 to 36 mm, the duct from 50 mm.
TEST(Surroundings, DistancesReachTheBorderAndIgnoreOuterAir) {
    const patient::Package package = test::wallWithVessel();
    const patient::Patient patient(package);
    const Surroundings around(patient, test::wallPath());
    EXPECT_NEAR(around.distanceToRisk_m({0.0205, 0.0005, 0.0005}), 0.0115, 1e-6);
    EXPECT_NEAR(around.distanceToRisk_m({0.0305, 0.0005, 0.0005}), 0.0015, 1e-6);
    EXPECT_EQ(around.distanceToRisk_m({0.0345, 0.0005, 0.0005}), 0.0);
    EXPECT_NEAR(around.distanceToRisk_m({0.0395, 0.0005, 0.0005}), 0.0035, 1e-6);
    EXPECT_GT(around.distanceToRisk_m({0.0005, 0.0005, 0.0005}), 0.030) << "outer air";
    EXPECT_NEAR(around.distanceToDuct_m({0.0405, 0.0005, 0.0005}), 0.0095, 1e-6);
    EXPECT_TRUE(std::isinf(around.distanceToRisk_m({5.0, 0.0, 0.0})));
    EXPECT_FALSE(around.ductAxis()) << "a slab runs no way";
}

TEST(Surroundings, GasInTheBodyIsARisk) {
    patient::Package package = test::wallWithVessel();
    const auto paint = [&](double low_m, double high_m) {
        for (std::size_t n = 0; n < package.labels.voxels.size(); ++n) {
            const double x =
                package.labels.grid.centre({int(n % std::size_t(package.labels.grid.dims.x)), 0, 0}).x;
            if (x > low_m && x < high_m) package.labels.voxels[n] = 0, package.ct.voxels[n] = -1000;
        }
    };
    paint(0.010, 0.012);
    const patient::Patient patient(package);
    const Surroundings around(patient, test::wallPath());
    EXPECT_EQ(around.distanceToRisk_m({0.0105, 0.0005, 0.0005}), 0.0);
    EXPECT_NEAR(around.distanceToRisk_m({0.0055, 0.0005, 0.0005}), 0.0045, 1e-6);
}

// A duct of 4 mm along y replaces the duct slab.
TEST(Surroundings, DuctAxisFollowsTheTube) {
    patient::Package package = test::wallWithVessel();
    LabelVolume& labels = package.labels;
    Index3 i;
    for (i.z = 0; i.z < labels.grid.dims.z; ++i.z)
        for (i.y = 0; i.y < labels.grid.dims.y; ++i.y)
            for (i.x = 0; i.x < labels.grid.dims.x; ++i.x)
                if (labels[i] == test::kDuctLabel && std::fabs(labels.grid.centre(i).z) > 0.002)
                    labels[i] = test::kLiverLabel;
    const patient::Patient patient(package);
    const Surroundings around(patient, test::wallPath());
    ASSERT_TRUE(around.ductAxis());
    EXPECT_GT(std::fabs(around.ductAxis()->y), 0.99);
}

}  // namespace
}  // namespace stylet::training
