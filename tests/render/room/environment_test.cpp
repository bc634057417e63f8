#include "render/room/environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "render/room/placement.h"
#include "render/room/scene_meshes.h"

namespace stylet::render {
namespace {

// Directions evenly distributed over the sphere.
glm::vec3 direction(int i, int count) {
    const float z = 1.0f - (2.0f * float(i) + 1.0f) / float(count), angle = 2.399963f * float(i);
    const float r = std::sqrt(1.0f - z * z);
    return {r * std::cos(angle), z, r * std::sin(angle)};
}

TEST(Environment, OctahedralMappingRoundTrips) {
    for (int i = 0; i < 500; ++i) {
        const glm::vec3 d = direction(i, 500);
        EXPECT_NEAR(glm::length(directionFromOctahedral(octahedralFromDirection(d)) - d), 0.0f, 1e-5f);
    }
}

// Cosine-weighted integral of the light over a hemisphere, divided by pi.
glm::vec3 gathered(const glm::vec3& normal) {
    glm::vec3 sum(0.0f);
    constexpr int kCount = 40000;
    for (int i = 0; i < kCount; ++i) {
        const glm::vec3 d = direction(i, kCount);
        sum += std::max(glm::dot(d, normal), 0.0f) * roomRadiance(kGatherPoint, d);
    }
    return 4.0f / kCount * sum;
}

TEST(Environment, NineCoefficientsReproduceTheIrradiance) {
    const Environment made = makeEnvironment();
    for (int i = 0; i < 30; ++i) {
        const glm::vec3 n = direction(i, 30), exact = gathered(n), held = irradianceAt(made.irradiance, n);
        EXPECT_NEAR(held.g, exact.g, 0.06f * gathered({0, 1, 0}).g) << n.x << ' ' << n.y << ' ' << n.z;
    }
}

// The volume's two colours (kSkyColour and kGroundColour in frame_shared.h) are this light from straight
// above and from straight below.
TEST(Environment, VolumeAmbientLightMatchesTheRoom) {
    const Environment made = makeEnvironment();
    const glm::vec3 sky = gpu::kSkyColour, ground = gpu::kGroundColour;
    const glm::vec3 above = irradianceAt(made.irradiance, {0, 1, 0}),
                    below = irradianceAt(made.irradiance, {0, -1, 0});
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(above[c], sky[c], 0.06f);
        EXPECT_NEAR(below[c], ground[c], 0.02f);
    }
}

TEST(Environment, RougherLevelsAreSmootherAndEquallyBright) {
    const Environment made = makeEnvironment();
    constexpr std::size_t kLayer = std::size_t(Environment::kSize) * Environment::kSize;
    float brightest_before = 1e9f;
    for (int level = 0; level < Environment::kLevels; ++level) {
        float brightest = 0.0f;
        for (std::size_t i = 0; i < kLayer; ++i)
            brightest = std::max(brightest, made.texels[std::size_t(level) * kLayer + i].g);
        EXPECT_LE(brightest, Environment::kBrightest);
        EXPECT_LE(brightest, 1.1f * brightest_before) << level;
        brightest_before = brightest;
    }
}

TEST(PathColour, LightnessRisesWithQuality) {
    float before = -1.0f;
    for (int i = 0; i <= 20; ++i) {
        const glm::vec3 c = pathColour(i / 20.0);
        const float luminance = 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b;
        EXPECT_GT(luminance, before) << i;
        before = luminance;
    }
    EXPECT_EQ(pathColour(-3.0), pathColour(0.0));
    EXPECT_EQ(pathColour(7.0), pathColour(1.0));
}

TEST(Placement, LampArmLinksMeetAtTheElbow) {
    const glm::dvec2 from(0.3, -0.2), to(1.1, 0.4);
    const glm::dvec2 elbow = findElbow(from, to, 0.9, 0.7);
    EXPECT_NEAR(glm::length(elbow - from), 0.9, 1e-12);
    EXPECT_NEAR(glm::length(elbow - to), 0.7, 1e-12);
    const glm::dvec2 far = findElbow({0, 0}, {5, 0}, 0.9, 0.7);
    EXPECT_NEAR(far.x, 0.9, 1e-6);
    EXPECT_NEAR(far.y, 0.0, 1e-6);
}

// Source 0.72 m below the isocentre, detector 0.38 m above it.
TEST(Placement, CArmRotatesAboutItsIsocentre) {
    RenderScene scene;
    const double half = std::sqrt(0.5);
    scene.stage_from_patient = {{half, 0.0, -half, 0.0}, {0.0, 1.0, -0.5}};
    const Placement placed = computePlacement(scene, nullptr);
    const CArmPoses rest = cArmPoses(scene, {}, placed);
    const Vec3 isocentre = rest.stage_from_arc * Vec3(0.0);
    const auto toward = [&](const CArm& arm) {
        return placed.stage_from_room.inverse().direction(
            glm::normalize(cArmPoses(scene, arm, placed).stage_from_arc * Vec3(0.0, 0.38, 0.0) - isocentre));
    };
    const double quarter = std::numbers::pi / 2;
    EXPECT_NEAR(glm::length(toward({}) - Vec3(0, 1, 0)), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(toward({.orbital_rad = quarter}) - Vec3(-1, 0, 0)), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(toward({.angulation_rad = quarter}) - Vec3(0, 0, 1)), 0.0, 1e-12);
    for (const CArm& arm : {CArm{0.4, -0.2}, CArm{-0.7, 0.5}})
        EXPECT_NEAR(glm::length(cArmPoses(scene, arm, placed).stage_from_arc * Vec3(0.0) - isocentre), 0.0,
                    1e-12);
    // Moved to another isocentre, the C-arm turns about that point.
    const Vec3 wanted(0.06, 0.03, 0.11);
    const CArm there{0.4, -0.2, wanted};
    EXPECT_NEAR(glm::length(cArmPoses(scene, there, placed).stage_from_arc * Vec3(0.0) -
                            scene.stage_from_patient * wanted),
                0.0, 1e-12);
}

}  // namespace
}  // namespace stylet::render
