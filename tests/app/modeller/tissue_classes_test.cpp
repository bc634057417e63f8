// A synthetic body with known HU values and known noise.
#include "app/modeller/import/tissue_classes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "app/modeller/import/import_map.h"

namespace stylet::modeller {
namespace {

constexpr double kNoise_hu = 9.0;

// An upright cylinder of fat. Inside it lies muscle with ribs, then lung on one side and uniform blood on
// the other.
struct BodyPhantom {
    CtVolume ct{Grid{{120, 100, 60}, Vec3(0.0025), Vec3(0.0)}, -1000};
    Mask body{ct.grid};
    LabelVolume labels{ct.grid};  // bones, lung and blood

    explicit BodyPhantom(double blood_hu) {
        std::mt19937 random(7);
        std::normal_distribution<double> noise(0.0, kNoise_hu);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const Vec3 p = ct.grid.centre(i) - Vec3(0.15, 0.125, 0.0);
            const double r = std::hypot(p.x / 0.13, p.y / 0.105);
            if (r > 1.0) return;
            body[i] = 1;
            double hu = -105.0;
            if (r < 0.85) hu = 60.0;
            if (r < 0.85 && r > 0.75 && i.z % 12 < 4) {
                hu = 400.0 + 60.0 * std::sin(i.x);
                labels[i] = targetId("bone");
            }
            if (r < 0.6) {
                hu = p.x > 0.0 ? -850.0 : blood_hu;
                labels[i] = targetId(p.x > 0.0 ? "right lung" : "portal vein");
            }
            ct[i] = std::int16_t(std::lround(hu + noise(random)));
        });
    }
};

TEST(TissueClasses, MatchSyntheticBody) {
    const BodyPhantom made(180.0);
    const TissueClasses c = estimateTissueClasses(made.ct, made.body);
    EXPECT_NEAR(c.fat.mean_hu, -105.0, 3.0);
    EXPECT_NEAR(c.fat.sigma_hu, kNoise_hu, 2.0);
    EXPECT_NEAR(c.soft.mean_hu, 60.0, 3.0);
    EXPECT_NEAR(c.blood.mean_hu, 180.0, 3.0);
    EXPECT_NEAR(c.bone.mean_hu, 400.0, 15.0);
    const patient::Thresholds t = computeThresholds(c);
    EXPECT_NEAR(t.t1_hu, c.fat.mean_hu - 5.5 * c.fat.sigma_hu, 0.51);
    EXPECT_LT(t.t0_hu, t.t1_hu);
    EXPECT_GE(t.t2_sensitive_hu, c.soft.mean_hu + 5.5 * c.soft.sigma_hu - 0.51);
    EXPECT_LT(t.t2_sensitive_hu, c.bone.mean_hu);
    EXPECT_GE(t.t2_specific_hu, c.blood.mean_hu + 4.0 * c.blood.sigma_hu - 0.51);
}

TEST(TissueClasses, WithoutContrastThereIsNoBlood) {
    const BodyPhantom made(45.0);
    const TissueClasses c = estimateTissueClasses(made.ct, made.body);
    EXPECT_EQ(c.blood.share, 0.0);
    const patient::Thresholds t = computeThresholds(c);
    EXPECT_EQ(t.t2_specific_hu, t.t2_sensitive_hu);
}

// The classes are the same with and without labels.
TEST(TissueClasses, LabelledAndUnlabelledEstimatesAgree) {
    const BodyPhantom made(180.0);
    const TissueClasses with = estimateTissueClasses(made.ct, made.body, made.labels),
                        without = estimateTissueClasses(made.ct, made.body);
    const auto same = [](const TissueClass& a, const TissueClass& b, double within_hu) {
        EXPECT_NEAR(a.mean_hu, b.mean_hu, within_hu);
        EXPECT_NEAR(a.sigma_hu, b.sigma_hu, within_hu);
    };
    same(with.fat, without.fat, 1.0);
    same(with.soft, without.soft, 1.0);
    same(with.blood, without.blood, 2.0);
    same(with.bone, without.bone, 15.0);
    const patient::Thresholds a = computeThresholds(with), b = computeThresholds(without);
    EXPECT_NEAR(a.t1_hu, b.t1_hu, 5.0);
    EXPECT_NEAR(a.t2_sensitive_hu, b.t2_sensitive_hu, 5.0);
    EXPECT_NEAR(a.t2_specific_hu, b.t2_specific_hu, 10.0);
}

TEST(TissueClasses, WithoutBoneSoftTissueNoiseSetsTheThreshold) {
    TissueClasses c{{-105.0, 9.0, 0.5}, {60.0, 9.0, 0.5}, {}, {}};
    const patient::Thresholds t = computeThresholds(c);
    EXPECT_EQ(t.t2_sensitive_hu, std::round(60.0 + 5.5 * 9.0));
    EXPECT_EQ(t.t2_specific_hu, t.t2_sensitive_hu);
    c.bone = {400.0, 80.0, 0.1};
    EXPECT_GT(computeThresholds(c).t2_sensitive_hu, 100.0);
    EXPECT_LT(computeThresholds(c).t2_sensitive_hu, 200.0);
}

}  // namespace
}  // namespace stylet::modeller
