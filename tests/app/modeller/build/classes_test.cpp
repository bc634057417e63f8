// A body made of known values and known noise.
#include "app/modeller/build/classes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stylet::modeller {
namespace {

using patient::Grid;
using patient::Index3;
using patient::Vec3;

constexpr double kNoise_hu = 9.0;

// A cylinder upright: fat, in it muscle with ribs, in it lung on one side and even blood on the other.
struct MadeBody {
    patient::CtVolume ct{Grid{{120, 100, 60}, Vec3(0.0025), Vec3(0.0)}, -1000};
    Mask body{ct.grid};

    explicit MadeBody(double blood_hu) {
        std::mt19937 random(7);
        std::normal_distribution<double> noise(0.0, kNoise_hu);
        for (int z = 0; z < ct.grid.dims.z; ++z)
            for (int y = 0; y < ct.grid.dims.y; ++y)
                for (int x = 0; x < ct.grid.dims.x; ++x) {
                    const Index3 i{x, y, z};
                    const Vec3 p = ct.grid.centre(i) - Vec3(0.15, 0.125, 0.0);
                    const double r = std::hypot(p.x / 0.13, p.y / 0.105);
                    if (r > 1.0) continue;
                    body[i] = 1;
                    double hu = -105.0;
                    if (r < 0.85) hu = z % 12 < 4 && r > 0.75 ? 400.0 + 60.0 * std::sin(x) : 60.0;
                    if (r < 0.6) hu = p.x > 0.0 ? -850.0 : blood_hu;
                    ct[i] = std::int16_t(std::lround(hu + noise(random)));
                }
    }
};

TEST(Classes, AreThoseThatWereMade) {
    const MadeBody made(180.0);
    const TissueClasses c = classesOf(made.ct, made.body);
    EXPECT_NEAR(c.noise_hu, kNoise_hu, 1.0);
    EXPECT_NEAR(c.lung.mean_hu, -850.0, 3.0);
    EXPECT_NEAR(c.fat.mean_hu, -105.0, 3.0);
    EXPECT_NEAR(c.fat.sigma_hu, kNoise_hu, 2.0);
    EXPECT_NEAR(c.soft.mean_hu, 60.0, 3.0);
    EXPECT_NEAR(c.blood.mean_hu, 180.0, 3.0);
    EXPECT_NEAR(c.bone.mean_hu, 400.0, 15.0);
    const patient::Thresholds t = thresholdsOf(c);
    EXPECT_NEAR(t.t1_hu, c.fat.mean_hu - 5.5 * c.fat.sigma_hu, 0.51);
    EXPECT_LT(t.t0_hu, t.t1_hu);
    EXPECT_GE(t.t2_sensitive_hu, c.soft.mean_hu + 5.5 * c.soft.sigma_hu - 0.51);
    EXPECT_LT(t.t2_sensitive_hu, c.bone.mean_hu);
    EXPECT_GE(t.t2_specific_hu, c.blood.mean_hu + 4.0 * c.blood.sigma_hu - 0.51);
}

TEST(Classes, WithoutContrastThereIsNoBlood) {
    const MadeBody made(45.0);
    const TissueClasses c = classesOf(made.ct, made.body);
    EXPECT_EQ(c.blood.share, 0.0);
    const patient::Thresholds t = thresholdsOf(c);
    EXPECT_EQ(t.t2_specific_hu, t.t2_sensitive_hu);
}

}  // namespace
}  // namespace stylet::modeller
