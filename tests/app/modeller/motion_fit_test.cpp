#include "app/modeller/motion/motion_fit.h"

#include <gtest/gtest.h>

#include <random>

#include "app/modeller/motion/motion_cavity.h"
#include "tests/app/modeller/chest.h"
#include "tests/support/refused.h"

namespace stylet::modeller {
namespace {

using patient::Surrogate;

TEST(Dome, HeightHasSubvoxelAccuracy) {
    const auto phases = test::chestPhases();
    const DomeMap map = findDome(phases[0].hu);
    // The dome is 10 mm high in the centre. The edge is one voxel wide; the border's HU lies at 0.418 of it.
    EXPECT_NEAR(map.heightAt(0.0, 0.0), 0.010, 0.0005);
    EXPECT_NEAR(map.heightAt(0.030, 0.0), 0.010 - 4.0 * 0.0009, 0.0006);
    const DomeMap inhaled = findDome(phases[4].hu);
    EXPECT_NEAR(inhaled.heightAt(0.010, -0.010) - map.heightAt(0.010, -0.010), -0.010, 0.0005);
    EXPECT_TRUE(std::isnan(map.heightAt(0.5, 0.0)));
}

TEST(Dome, LungDensityExcludesTheDomeColumns) {
    const auto phases = test::chestPhases();
    std::vector<DomeMap> maps;
    for (const Phase& phase : phases)
        maps.push_back(findDome(phase.hu));
    const DomeColumns dome_columns = selectDomeColumns(maps, 0);
    EXPECT_GT(dome_columns.columns.size(), 1000u);
    EXPECT_NEAR(dome_columns.slice_y, phases[0].hu.grid.dims.y / 2, 2);
    // A tube has no lung beside its dome, so there is no surrogate.
    EXPECT_THROW((void)lungDensityOutsideDome(phases, dome_columns), ImportError);
    DomeColumns few = dome_columns;
    few.columns.resize(50);
    const std::vector<double> means = lungDensityOutsideDome(phases, few);
    const std::vector<Surrogate> surrogates = makeSurrogates(means, 4.0);
    for (int p = 0; p < 8; ++p)
        EXPECT_NEAR(surrogates[std::size_t(p)].v, test::breathingState(p, 8), 0.1);
}

TEST(Dome, ImagesWithoutBreathingAreRefused) {
    std::vector<Phase> phases = test::chestPhases({.phases = 1});
    for (float& hu : phases[0].hu.voxels)
        hu = 50.0f;
    EXPECT_THROW((void)selectDomeColumns({findDome(phases[0].hu)}, 0), ImportError);
    EXPECT_THROW((void)chestCavity(phases), ImportError);
    EXPECT_THROW((void)makeSurrogates({-800.0, -800.2, -800.1, -800.0}, 4.0), ImportError);
}

TEST(Cavity, EndsInsideTheRibs) {
    const auto phases = test::chestPhases();
    const Mask cavity = chestCavity(phases);
    const FloatVolume level = signedDistance(cavity);
    double worst_m = 0.0;
    forEachVoxel(cavity.grid, [&](const Index3& i) {
        const Vec3 p = cavity.grid.centre(i);
        const double off_m = std::hypot(p.x, p.y) - 0.068;
        if (std::fabs(off_m) < 0.015) worst_m = std::max(worst_m, std::fabs(double(level[i]) - off_m));
    });
    EXPECT_LT(worst_m, 0.004);  // also below the lung
}

TEST(Surrogates, RateIsTheSlopeAroundTheCycle) {
    const std::vector<Surrogate> s = makeSurrogates({-700.0, -750.0, -800.0, -750.0}, 4.0);
    ASSERT_EQ(s.size(), 4u);
    EXPECT_EQ(s[0], (Surrogate{0.0, 0.0}));
    EXPECT_EQ(s[1], (Surrogate{0.5, 0.5}));
    EXPECT_EQ(s[2], (Surrogate{1.0, 0.0}));
    EXPECT_EQ(s[3], (Surrogate{0.5, -0.5}));
}

TEST(Regression, RecoversTheCoefficientsOfSyntheticFields) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-0.02, 0.02);
    const std::size_t nodes = 50, phases = 8, reference = 2;
    std::vector<Surrogate> surrogates;
    for (std::size_t p = 0; p < phases; ++p)
        surrogates.push_back({test::breathingState(int(p), 8), std::sin(0.8 * double(p))});
    std::vector<Vec3> a1(nodes), a2(nodes);
    for (std::size_t i = 0; i < nodes; ++i)
        a1[i] = {any(random), any(random), any(random)}, a2[i] = {any(random), any(random), any(random)};
    std::vector<NodeVelocities> velocities(phases);
    for (std::size_t p = 0; p < phases; ++p) {
        for (std::size_t i = 0; i < nodes; ++i)
            velocities[p].slide_m.push_back(
                a1[i] * (surrogates[p].v - surrogates[reference].v) +
                a2[i] * (surrogates[p].rate_per_s - surrogates[reference].rate_per_s));
        velocities[p].wall_m.assign(nodes, Vec3(0.0));
    }
    // A wrong phase that is left out has no effect.
    velocities[5].slide_m.assign(nodes, Vec3(1.0));
    patient::MotionModel m;
    m.wall.resize(nodes), m.slide.resize(nodes);
    regress(velocities, surrogates, reference, 5, m);
    for (std::size_t i = 0; i < nodes; ++i)
        for (int d = 0; d < 3; ++d) {
            ASSERT_NEAR(double(m.slide[i].a1_m[std::size_t(d)]), a1[i][d], 1e-8);
            ASSERT_NEAR(double(m.slide[i].a2_m_s[std::size_t(d)]), a2[i][d], 1e-8);
            ASSERT_EQ(m.wall[i].a1_m[std::size_t(d)], 0.0f);
        }
    // If the surrogate has no rate, a2 is zero.
    for (Surrogate& s : surrogates)
        s.rate_per_s = 0.0;
    regress(velocities, surrogates, reference, 5, m);
    EXPECT_EQ(m.slide[7].a2_m_s[0], 0.0f);
}

TEST(PhaseSignal, IsParsedAndErrorsNameTheLine) {
    const std::string good = "phase,v,rate_per_s\n1,0,0\n2,0.5,1.25\n3,1,-0.5\r\n";
    const auto read = parsePhaseSignal(good, "s.csv", 3);
    EXPECT_EQ(read, (std::vector<Surrogate>{{0.0, 0.0}, {0.5, 1.25}, {1.0, -0.5}}));
    const auto refused = [](const std::string& text, const std::string& field) {
        test::expectRefused([&] { (void)parsePhaseSignal(text, "s.csv", 3); }, "s.csv", field);
    };
    refused("", "line 1");
    refused("v,rate\n", "line 1");
    refused("phase,v,rate_per_s\n1,0,0\n", "phase");
    refused(good + "4,0,0\n", "line 5");
    refused("phase,v,rate_per_s\n1,0\n", "line 2");
    refused("phase,v,rate_per_s\n1,0,0,0\n", "line 2");
    refused("phase,v,rate_per_s\n1,nan,0\n", "line 2");
    refused("phase,v,rate_per_s\n1,inf,0\n", "line 2");
    refused("phase,v,rate_per_s\n1,1e300,0\n", "line 2");
    refused("phase,v,rate_per_s\n1,,0\n", "line 2");
    refused("phase,v,rate_per_s\n1,1;2,0\n", "line 2");
    EXPECT_THROW((void)readPhaseSignal("no-such.csv", 3), DataError);
}

}  // namespace
}  // namespace stylet::modeller
