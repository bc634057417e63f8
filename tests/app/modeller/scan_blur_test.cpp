#include "app/modeller/image/scan_blur.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/app/modeller/lung_phantom.h"
#include "tests/support/seed.h"

namespace stylet::modeller {
namespace {

// A body with a curved front, blurred by a normal distribution.
CtVolume bodyWithEdge(double blur_voxels, double noise_hu, double spacing_m = 0.001) {
    CtVolume ct({Index3(120, 80, 40), Vec3(spacing_m), Vec3(0.0)}, -1000);
    std::mt19937_64 random(test::seed());
    std::normal_distribution<double> noise(0.0, noise_hu);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        const double front = 60.3 - 0.0015 * (i.x - 60) * (i.x - 60) + 0.11 * i.z;
        const double share = 0.5 * std::erfc((i.y - front) / (blur_voxels * std::sqrt(2.0)));
        ct[i] = std::int16_t(std::lround(-1000.0 + 1050.0 * share + noise(random)));
    });
    return ct;
}

TEST(ScanBlur, MatchesTheBlurOfThePhantom) {
    for (const double blur : {0.5, 0.7, 1.0, 1.5})
        for (const double noise_hu : {0.0, 30.0}) {
            const double found = 1e3 * measureBlurWithin(bodyWithEdge(blur, noise_hu)).value();
            // The skin's value is that of its brightest voxel, which noise raises: the edge seems wider.
            EXPECT_NEAR(found, blur, 0.08 * blur + 0.002 * noise_hu) << noise_hu << " HU of noise";
        }
    EXPECT_NEAR(measureBlurWithin(bodyWithEdge(0.7, 10.0, 0.002)).value(), 0.0014, 0.00014);
    EXPECT_NEAR(measureBlurWithin(bodyWithEdge(2.5, 0.0)).value(), 0.002, 0.0001);
}

// Adversaries: a sharp blanket on a third of the body; on most of it, bedding that fills the air, or a steep
// flank that looks softer; cables in the air; air that was cut away, no air, nothing at all.
TEST(ScanBlur, OnlySkinInAirCounts) {
    constexpr int kMost = 96;
    const auto error = [](const auto& change) {
        CtVolume ct = bodyWithEdge(1.0, 10.0);
        forEachVoxel(ct.grid, [&](const Index3& i) { change(i, ct[i]); });
        return std::fabs(measureBlurWithin(ct).value() - 0.001);
    };
    const auto blanket = [](const Index3& i, std::int16_t& hu) {
        if (i.x < 40 && i.y <= 64) hu = std::max<std::int16_t>(hu, -400);
    };
    const auto bedding = [](const Index3& i, std::int16_t& hu) {
        if (i.x < kMost) hu = std::max<std::int16_t>(hu, -700);
    };
    const auto flank = [](const Index3& i, std::int16_t& hu) {
        const double out = i.y - 44.0 - 0.3 * i.x;
        if (i.x < kMost) hu = std::int16_t(-1000 + 525 * std::erfc(out / 4.0));
    };
    const auto cables = [](const Index3& i, std::int16_t& hu) {
        if (i.x % 10 == 0 && i.y >= 66 && i.y < 69) hu = 2000;
    };
    EXPECT_LT(error(blanket), 0.00015);
    EXPECT_LT(error(bedding), 0.00015);
    EXPECT_LT(error(flank), 0.00015);
    EXPECT_LT(error(cables), 0.00015);
    CtVolume cut = bodyWithEdge(1.0, 10.0);
    for (std::int16_t& hu : cut.voxels)
        if (hu < -200) hu = -1024;
    EXPECT_FALSE(measureBlurWithin(cut));
    const Grid g{Index3(40), Vec3(0.001), Vec3(0.0)};
    for (const std::int16_t hu : {50, -1000})
        EXPECT_FALSE(measureBlurWithin(CtVolume(g, hu))) << hu;
    EXPECT_FALSE(measureBlurWithin(CtVolume({Index3(1), Vec3(0.001), Vec3(0.0)}, 50)));
}

TEST(ScanBlur, AcrossSlicesMatchesTheBlurOfTheDiaphragm) {
    for (const double blur : {0.5, 0.7, 1.0, 1.5})
        for (const double noise_hu : {0.0, 20.0})
            EXPECT_NEAR(1e3 * measureBlurAcross(test::lungOnDiaphragm(blur, noise_hu)).value(), blur,
                        0.08 * blur + 0.001 * noise_hu)
                << noise_hu << " HU of noise";
}

// Adversaries: a part of the diaphragm moved while it was scanned; fat under it; a steep diaphragm; lung that
// is full of fluid; air instead of lung; nothing at all.
TEST(ScanBlur, OnlyAClearDiaphragmCounts) {
    CtVolume moved = test::lungOnDiaphragm(1.0, 10.0);
    const CtVolume soft = test::lungOnDiaphragm(2.5, 10.0);
    forEachVoxel(moved.grid, [&](const Index3& i) {
        if (i.x < 20) moved[i] = soft[i];
    });
    EXPECT_NEAR(measureBlurAcross(moved).value(), 0.001, 0.00015);
    CtVolume fat = test::lungOnDiaphragm(1.0, 10.0);
    for (std::int16_t& hu : fat.voxels)
        if (hu > -100) hu = -100;
    EXPECT_FALSE(measureBlurAcross(fat));
    EXPECT_FALSE(measureBlurAcross(test::lungOnDiaphragm(1.0, 10.0, 0.4)));
    EXPECT_FALSE(measureBlurAcross(test::lungOnDiaphragm(1.0, 10.0, 0.05, -600.0)));
    EXPECT_FALSE(measureBlurAcross(test::lungOnDiaphragm(1.0, 10.0, 0.05, -1000.0)));
    EXPECT_FALSE(measureBlurAcross(CtVolume({Index3(1), Vec3(0.001), Vec3(0.0)}, 50)));
}

}  // namespace
}  // namespace stylet::modeller
