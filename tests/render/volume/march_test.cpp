// Tests the double-precision reference against closed forms, and the march on the processor against the
// reference.
#include "render/volume/march.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/render/volume/march_reference.h"

namespace stylet::render {
namespace {

using glm::dvec2;
using test::distance;
using test::MarchCase;

constexpr std::uint32_t kMarchPictureSize = 96;

LookStyle plainLook(double full_per_m) {
    LookStyle look;
    look.full_extinction_per_m = full_per_m;
    return look;
}

// A cube of 1 mm voxels, centred on the origin. `stored` returns a voxel's stored opacity, 0 to 255.
MarchCase cube(int voxels, const LookStyle& look, const std::function<int(const Index3&)>& stored) {
    Grid grid;
    grid.dims = Index3(voxels);
    grid.origin_m = Vec3(-0.0005 * (voxels - 1));
    std::vector<std::byte> rgba(grid.voxelCount() * 4);
    forEachVoxel(grid, [&](const Index3& i) {
        std::fill_n(rgba.begin() + std::ptrdiff_t(4 * grid.offset(i)), 4, std::byte(stored(i)));
    });
    return MarchCase(grid, std::move(rgba), look);
}

// Views from so far away that the rays are nearly parallel: along -z, `half_m` to either side.
std::array<View, 2> fromAfar(double half_m) {
    const double away_m = 10.0;
    return test::stereo(test::lookAt(Vec3(0.0, 0.0, away_m), Vec3(0.0), float(std::atan(half_m / away_m))),
                        1e-6);
}

double opacityAt(const MarchCase& c, double half_m, double x_m, double y_m) {
    const auto frame = c.frame(fromAfar(half_m), 64, 64, 1.0f);
    const dvec2 at(0.5 + 0.5 * x_m / half_m, 0.5 - 0.5 * y_m / half_m);
    return test::referenceRay(c, frame, 0, at, {.step_voxels = 0.02}).opacity;
}

// Extinction = a^2 * full. Between the last voxel's centre and its face the stored opacity a falls to half.
constexpr double kFace_m = 0.001 * (1.0 - 0.125) / 3.0;

TEST(MarchReference, SlabFollowsBeersLaw) {
    const MarchCase slab = cube(32, plainLook(40.0), [](const auto&) { return 255; });
    const double path_m = 0.031 + 2.0 * kFace_m;
    EXPECT_NEAR(opacityAt(slab, 0.02, 0.003, 0.002), 1.0 - std::exp(-40.0 * path_m), 1e-4);
    const MarchCase half = cube(32, plainLook(40.0), [](const auto&) { return 102; });
    EXPECT_NEAR(opacityAt(half, 0.02, 0.003, 0.002), 1.0 - std::exp(-0.16 * 40.0 * path_m), 1e-4);
}

TEST(MarchReference, WedgeExtinctionIsTheSquareOfTheStoredOpacity) {
    const MarchCase wedge = cube(48, plainLook(60.0), [](const auto& i) { return 5 * i.x; });
    const double path_m = 0.047 + 2.0 * kFace_m;
    for (const double x_m : {-0.02, -0.0101, 0.0, 0.0037, 0.0163}) {
        const double stored = 5.0 * (x_m * 1000.0 + 23.5) / 255.0;
        EXPECT_NEAR(opacityAt(wedge, 0.025, x_m, 0.001), 1.0 - std::exp(-60.0 * stored * stored * path_m),
                    2e-4)
            << x_m;
    }
}

TEST(MarchReference, SphereMatchesChordLengths) {
    const double radius_m = 0.040;
    const MarchCase ball = cube(96, plainLook(15.0), [&](const Index3& i) {
        const double r_m = 0.001 * glm::length(Vec3(i) - 47.5);
        return int(std::lround(255.0 * std::sqrt(std::clamp((radius_m - r_m) / 0.001 + 0.5, 0.0, 1.0))));
    });
    for (const double b_m : {0.0, 0.0112, 0.0243, 0.0338}) {
        const double chord_m = 2.0 * std::sqrt(radius_m * radius_m - b_m * b_m);
        EXPECT_NEAR(opacityAt(ball, 0.05, b_m, 0.0), 1.0 - std::exp(-15.0 * chord_m), 0.006) << b_m;
    }
}

TEST(March, SlabFollowsBeersLaw) {
    Workers workers(1);
    const MarchCase slab = cube(32, plainLook(40.0), [](const auto&) { return 255; });
    for (const MarchPath path : {MarchPath::widest, MarchPath::portable}) {
        const auto layer =
            test::marchLayer(slab, workers, slab.frame(fromAfar(0.02), 16, 16, 0.25f), {.path = path});
        const double path_m = 0.031 + 2.0 * kFace_m;
        // The path may be wrong by half a step at its start. Half-precision floats have eleven bits.
        EXPECT_NEAR(double(layer.colour[8 * 16 + 8].a), 1.0 - std::exp(-40.0 * path_m), 0.004);
        EXPECT_EQ(layer.colour[0].a, 0.0f);
    }
}

struct Trunk {
    patient::Package package = test::makeTrunk(0.003);
    patient::Patient patient{package};
    std::array<View, 2> eyes =
        test::stereo(test::lookAt(Vec3(0.35, 0.35, 0.35), Vec3(0, 0, 0), 0.35f), 0.063);

    MarchCase in(Look look) const {
        const char* file = look == Look::closed ? "closed.toml" : "reveal.toml";
        LookStyle style = loadLook(test::assetsFolder() / "looks" / file);
        style.mottle = style.pores = 0.0f;  // the reference does not model skin texture
        return MarchCase(patient, style);
    }
};

class MarchTest : public testing::TestWithParam<std::tuple<Look, double>> {};

TEST_P(MarchTest, AgreesWithTheReference) {
    const auto [look, v] = GetParam();
    const Trunk trunk;
    const MarchCase c = trunk.in(look);
    DeformTables tables;
    if (v != 0.0) tables = deformTables(trunk.package.motion, {.v = v});
    const DeformTables* deformation = v != 0.0 ? &tables : nullptr;
    const auto frame = c.frame(trunk.eyes, kMarchPictureSize, kMarchPictureSize, 2.0f);
    const auto reference = test::referenceLayer(c, frame, {.step_voxels = 0.1, .deformation = deformation});
    Workers workers(2);
    for (const auto& [step, bound_db] : {std::pair{2.0f, 40.0}, std::pair{0.25f, 50.0}}) {
        const auto marched =
            test::marchLayer(c, workers, c.frame(trunk.eyes, kMarchPictureSize, kMarchPictureSize, step),
                             {.deformation = deformation});
        const auto d = distance(marched, reference);
        EXPECT_GE(d.psnr_db, bound_db) << step;
        if (step > 1.0f) continue;
        EXPECT_LE(d.worst, 0.06);
        // Depth of half absorption. For a translucent ray it may lie in another organ.
        std::vector<double> off_m;
        for (std::size_t i = 0; i < marched.depth_m.size(); ++i)
            if (reference.depth_m[i] > 0.0f && marched.depth_m[i] > 0.0f)
                off_m.push_back(double(std::fabs(marched.depth_m[i] - reference.depth_m[i])));
        ASSERT_GT(off_m.size(), 1000u);
        const auto p95 = off_m.begin() + std::ptrdiff_t(0.95 * double(off_m.size()));
        std::nth_element(off_m.begin(), p95, off_m.end());
        EXPECT_LE(*p95, 0.5 * 0.003);
    }
}

TEST_P(MarchTest, PictureIsIndependentOfPathAndThreads) {
    const auto [look, v] = GetParam();
    const Trunk trunk;
    const MarchCase c = trunk.in(look);
    DeformTables tables;
    if (v != 0.0) tables = deformTables(trunk.package.motion, {.v = v});
    const DeformTables* deformation = v != 0.0 ? &tables : nullptr;
    const auto frame = c.frame(trunk.eyes, kMarchPictureSize, kMarchPictureSize, 2.0f);
    Workers one(1), three(3);
    const auto alone = test::marchLayer(c, one, frame, {.deformation = deformation});
    EXPECT_EQ(alone.colour, test::marchLayer(c, three, frame, {.deformation = deformation}).colour);
    const auto portable =
        test::marchLayer(c, one, frame, {.path = MarchPath::portable, .deformation = deformation});
    EXPECT_GE(distance(alone, portable).psnr_db, 60.0);
}

TEST_P(MarchTest, SkipsChangeTheWorkButNotThePicture) {
    const auto [look, v] = GetParam();
    const Trunk trunk;
    MarchCase c = trunk.in(look);
    Workers workers(2);
    DeformTableBuilder maker(trunk.package.motion, {}, nullptr);
    if (v != 0.0) {
        maker.compute({.v = v}, workers);
        BreathingBricks bricks(c.bricks);
        bricks.update(c.grid, maker.tables(), maker.reach_m(), workers);
        c.brick_distance = leapDistances(bricks.occupancy());
    }
    const auto frame = c.frame(trunk.eyes, kMarchPictureSize, kMarchPictureSize, 2.0f);
    // A plane across the body, 0.55 m in front of the eyes.
    const float near = frame.target.z, far = frame.target.w;
    const std::vector<float> mesh(std::size_t(2) * kMarchPictureSize * kMarchPictureSize,
                                  near * (far / 0.55f - 1.0f) / (far - near));
    gpu::Counters all{}, other{};
    const auto run = [&](const Skips& skips, gpu::Counters& counted) {
        return test::marchLayer(
            c, workers, frame,
            {.skips = skips, .deformation = v != 0.0 ? &maker.tables() : nullptr, .mesh_depth = mesh},
            &counted);
    };
    const auto with_all = run({}, all);
    EXPECT_GT(all.skipped_bricks, 0u);
    EXPECT_GT(all.terminated_rays, 0u);
    EXPECT_GT(all.depth_bounded_rays, 0u);
    EXPECT_GE(distance(run({.empty_space = false}, other), with_all).psnr_db, 60.0);
    EXPECT_EQ(other.skipped_bricks, 0u);
    EXPECT_GT(other.samples, all.samples);
    EXPECT_GE(distance(run({.early_termination = false}, other), with_all).psnr_db, 60.0);
    EXPECT_EQ(other.terminated_rays, 0u);
    EXPECT_GT(other.samples, all.samples);
    EXPECT_GE(distance(run({.depth_bounds = false}, other), with_all).psnr_db, 60.0);
    EXPECT_EQ(other.depth_bounded_rays, 0u);
    EXPECT_GT(other.samples, all.samples);
}

INSTANTIATE_TEST_SUITE_P(BothLooksStillAndBreathing, MarchTest,
                         testing::Combine(testing::Values(Look::closed, Look::reveal),
                                          testing::Values(0.0, 0.8)));

TEST(Workers, RunEveryJobExactlyOnce) {
    for (const int threads : {1, 2, 5}) {
        Workers workers(threads);
        EXPECT_EQ(workers.threads(), threads);
        for (const std::size_t jobs : {std::size_t(0), std::size_t(1), std::size_t(1000)}) {
            std::vector<int> done(jobs, 0);
            workers.run(jobs, [&](std::size_t job, int thread) { done[job] += thread < threads ? 1 : 100; });
            EXPECT_EQ(done, std::vector<int>(jobs, 1));
        }
    }
}

}  // namespace
}  // namespace stylet::render
