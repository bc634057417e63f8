#include "app/report/breath.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/report/film.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::report {
namespace {

using patient::Tissue;

// Dome positions that are linear in v, plus a lag proportional to its rate. Plotted over v they form an
// ellipse.
std::vector<BreathSample> ellipse(double lag_m_s) {
    std::vector<BreathSample> samples;
    for (int i = 0; i < 360; ++i) {
        const double turn = i * 2.0 * 3.14159265358979323846 / 360.0;
        BreathSample s;
        s.t_s = 0.01 * i;
        s.breath = {0.5 - 0.5 * std::cos(turn), std::sin(turn)};
        s.dome_m = 0.015 * s.breath.v + lag_m_s * s.breath.rate_per_s;
        samples.push_back(s);
    }
    return samples;
}

TEST(DomeRegression, FitsALineThroughTheSamples) {
    const DomeRegression straight = fitDomeMotion(ellipse(0.0));
    EXPECT_NEAR(straight.correlation, 1.0, 1e-12);
    EXPECT_NEAR(straight.slope_m, 0.015, 1e-12);
    EXPECT_NEAR(straight.travel_m, 0.015, 1e-12);
    EXPECT_NEAR(straight.residual_rms_m, 0.0, 1e-9);
    // v and its rate are uncorrelated over a cycle. The line is unchanged, and the RMS of the residual is
    // lag / sqrt 2.
    const DomeRegression lagging = fitDomeMotion(ellipse(0.001));
    EXPECT_NEAR(lagging.slope_m, 0.015, 1e-12);
    EXPECT_NEAR(lagging.residual_rms_m, 0.001 / std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(lagging.correlation, 1.0 / std::hypot(1.0, 0.001 / 0.0075), 1e-9);
}

TEST(DomeRegression, ExcludesBreathHoldSamples) {
    std::vector<BreathSample> samples = ellipse(0.0);
    for (const double dome_m : {-0.001, -0.004})
        samples.push_back({4.0, {}, true, dome_m});
    const DomeRegression follows = fitDomeMotion(samples);
    EXPECT_NEAR(follows.slope_m, 0.015, 1e-12);
    EXPECT_EQ(follows.held_from_m, -0.004);
    EXPECT_EQ(follows.held_to_m, -0.001);
    EXPECT_EQ(fitDomeMotion({}).correlation, 0.0);
}

// A block of liver that moves by `travel_m` along z.
patient::Package movingBlock(double travel_m) {
    patient::Package package = test::makeSlabs({{Tissue::liver, 0.020}, {Tissue::soft, 0.020}}, 0.001);
    package.motion = test::makeShift(travel_m);
    return package;
}

TEST(DomePoint, IsTheTopOfTheLiverAndMovesWithTheBreath) {
    const patient::Package package = movingBlock(-0.012);
    const patient::Patient patient(package);
    const Vec3 dome = domePoint(patient);
    const Grid& grid = package.labels.grid;
    EXPECT_EQ(dome.z, grid.centre(grid.dims - 1).z);
    EXPECT_GT(dome.x, 0.0);
    EXPECT_LT(dome.x, 0.020);
    EXPECT_NEAR(domeBelowExhale_m(patient, {1.0, 0.0}, dome), 0.012, 1e-6);
    EXPECT_EQ(domeBelowExhale_m(patient, {}, dome), 0.0);
}

TEST(DomePoint, WithoutALiverIsTheTopOfTheTissueBelowTheLung) {
    patient::Package package = movingBlock(-0.012);
    std::fill(package.labels.voxels.begin(), package.labels.voxels.end(), std::uint8_t(0));
    const Grid& grid = package.ct.grid;
    const int border = grid.dims.z / 2;
    forEachVoxel(grid, [&](const Index3& i) {
        if (i.z >= border) package.ct[i] = -850;
    });
    const patient::Patient patient(package);
    EXPECT_EQ(domePoint(patient).z, grid.centre({0, 0, border - 1}).z);
    EXPECT_NEAR(domeBelowExhale_m(patient, {1.0, 0.0}, domePoint(patient)), 0.012, 1e-6);
}

TEST(CoronalFrame, MovesWithTheBreath) {
    const patient::Package package = movingBlock(-0.012);
    const patient::Patient patient(package);
    const double beyond_m = -1.0;  // outside the image, so that no mark is drawn
    const FilmFrame still = coronalFrame(patient, {}, 0.0, beyond_m);
    const FilmFrame moved = coronalFrame(patient, {1.0, 0.0}, 0.0, beyond_m);
    ASSERT_EQ(still.rgb.size(), std::size_t(still.width) * std::size_t(still.height) * 3);
    // The block (40 mm) moves 12 mm toward the feet: its old top is now air.
    const int top = still.height / 8, below = 3 * still.height / 8;
    const auto grey = [](const FilmFrame& f, int row) {
        int brightest = 0;
        for (int u = 0; u < f.width; ++u)
            brightest = std::max(brightest, int(f.rgb[std::size_t(row * f.width + u) * 3]));
        return brightest;
    };
    EXPECT_GT(grey(still, top), 60);
    EXPECT_LT(grey(moved, top), 20);
    EXPECT_GT(grey(moved, below), 60);
}

TEST(SheetColumns, SheetHasScreenProportionsAndFewEmptyPlaces) {
    EXPECT_EQ(sheetColumns(24, 600, 480), 6);
    EXPECT_EQ(sheetColumns(1, 600, 480), 1);
    for (int frames = 1; frames <= 120; ++frames) {
        const int columns = sheetColumns(frames, 1280, 674);
        ASSERT_GE(columns, 1);
        ASSERT_LE(columns, frames);
        const int rows = (frames + columns - 1) / columns;
        const double shape = columns * 1280.0 / (rows * 674.0);
        EXPECT_GT(shape, 0.6) << frames;
        EXPECT_LT(shape, 2.0) << frames;
        EXPECT_LE(rows * columns - frames, std::max(1.0, 0.25 * frames)) << frames;
    }
}

}  // namespace
}  // namespace stylet::report
