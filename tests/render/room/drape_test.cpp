#include "render/room/drape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/render/phantoms.h"

namespace stylet::render {
namespace {

class DrapeTest : public testing::Test {
  protected:
    // The trunk's outline, found in the voxels of makeTrunk().
    bool body(const Vec3& p) const {
        const Grid& grid = package.ct.grid;
        const Index3 i = grid.nearest(p);
        return grid.contains(i) && double(package.ct.voxels[grid.offset(i)]) >= package.thresholds.t0_hu;
    }
    Vec3 flank() const {
        Vec3 p(0.0, 0.02, 0.0);
        while (body(p))
            p.x += 0.001;
        return p;
    }
    const patient::Package package = test::makeTrunk(0.003);
    const patient::Patient patient{package};
    const double back_m = -0.11;
};

TEST_F(DrapeTest, LiesOutsideTheBodyAndOnTheTable) {
    const DrapeShape drape = makeDrape(patient, back_m, flank());
    ASSERT_EQ(drape.vertices.size(), drape.anchors_m.size());
    ASSERT_EQ(drape.vertices.size(), drape.follows.size());
    for (const std::uint32_t i : drape.indices) {
        ASSERT_LT(i, drape.vertices.size());
        EXPECT_FALSE(body(Vec3(drape.vertices[i].position_m)));
        EXPECT_NEAR(glm::length(drape.vertices[i].normal), 1.0f, 1e-4f);
    }
    // Where the cloth lies on the body, it stays close to it.
    for (std::size_t i = 0; i < drape.vertices.size(); ++i) {
        if (drape.follows[i] == 1.0f) {
            EXPECT_LT(glm::length(Vec3(drape.vertices[i].position_m) - drape.anchors_m[i]), 0.02);
        }
    }
}

TEST_F(DrapeTest, IsOpenAroundTheField) {
    const Vec3 field = flank();
    const DrapeShape drape = makeDrape(patient, back_m, field);
    double nearest = 1.0;
    for (const std::uint32_t i : drape.indices)
        nearest = std::min(nearest, glm::length(Vec3(drape.vertices[i].position_m) - field));
    EXPECT_GT(nearest, 0.9 * std::min(kOpeningAround_m, kOpeningAlong_m) - 0.01);
    EXPECT_LT(nearest, kOpeningAround_m + 0.01);
}

// The cloth begins at the rim also where the opening reaches the trunk's end, beyond which it would be
// larger than the CT.
TEST_F(DrapeTest, HasNoHoleBesideTheRim) {
    const Grid& grid = package.ct.grid;
    for (const double z_m : {0.0, grid.origin_m.z + 0.03, grid.centre(grid.dims - 1).z - 0.03}) {
        const DrapeShape drape = makeDrape(patient, back_m, flank() + Vec3(0.0, 0.0, z_m));
        // The rim's vertices are the last; those of the cloth that no triangle uses are in the opening.
        const std::uint32_t rim = *std::ranges::max_element(drape.indices) + 1 - 80 * 8;
        std::vector<bool> used(drape.vertices.size());
        for (const std::uint32_t i : drape.indices)
            used[i] = true;
        for (std::uint32_t r = rim; r < drape.vertices.size(); ++r) {
            double nearest_m = 1.0;
            for (std::uint32_t i = 0; i < rim; ++i)
                if (used[i])
                    nearest_m = std::min(nearest_m, double(glm::distance(drape.vertices[i].position_m,
                                                                         drape.vertices[r].position_m)));
            EXPECT_LT(nearest_m, 0.013) << z_m;
        }
    }
}

TEST_F(DrapeTest, BreathesWithTheSkinBelowIt) {
    const DrapeShape drape = makeDrape(patient, back_m, flank());
    std::vector<glm::vec3> moved(drape.vertices.size());
    moveDrape(drape, package.motion, package.motion.reference, moved);
    double farthest = 0.0;
    for (std::size_t i = 0; i < moved.size(); ++i)
        farthest = std::max(farthest, double(glm::length(moved[i] - drape.vertices[i].position_m)));
    EXPECT_LT(farthest, 1e-5);
    patient::Surrogate deep = package.motion.reference;
    deep.v += 0.8;
    moveDrape(drape, package.motion, deep, moved);
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const glm::vec3 way = moved[i] - drape.vertices[i].position_m;
        const glm::vec3 skin(patient::deformedFromReference(package.motion, deep, drape.anchors_m[i]) -
                             drape.anchors_m[i]);
        EXPECT_NEAR(glm::length(way - drape.follows[i] * skin), 0.0f, 1e-6f);
        farthest = std::max(farthest, double(glm::length(way)));
    }
    EXPECT_GT(farthest, 1e-4);
}

// Patients that are tiny or fill their box still get a finite cloth.
TEST_F(DrapeTest, EveryPatientGetsAFiniteDrape) {
    for (const auto& odd : {test::makeBall(patient::Tissue::liver, 0.02, 0.01, 0.004),
                            test::makeBlock(patient::Tissue::liver, Vec3(0.1, 0.1, 0.1), 0.005)}) {
        const patient::Patient shown(odd);
        for (const Vec3& field : {Vec3(0.0), Vec3(0.0, 1.0, 0.0), Vec3(-3.0, -3.0, 9.0)})
            for (const Vertex& v : makeDrape(shown, -0.02, field).vertices) {
                EXPECT_TRUE(std::isfinite(v.position_m.x) && std::isfinite(v.position_m.y) &&
                            std::isfinite(v.position_m.z));
                EXPECT_NEAR(glm::length(v.normal), 1.0f, 1e-4f);
            }
    }
}

}  // namespace
}  // namespace stylet::render
