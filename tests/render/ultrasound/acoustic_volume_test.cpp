#include "render/ultrasound/acoustic_volume.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/ultrasound/scan_shared.h"
#include "tests/render/ultrasound/scan_reference.h"
#include "tests/render/ultrasound/sound_phantoms.h"

namespace stylet::render {
namespace {

TEST(AcousticVoxels, PackAndUnpackAgree) {
    for (int k = 0; k < 400; ++k) {
        AcousticVoxel v;
        v.tissue = k % 32;
        v.other = (k * 7) % 32;
        v.border = k % 5 != 0;
        v.near = 0.02 + 0.85 * (k % 17) / 17.0;
        v.normal = glm::normalize(Vec3(std::sin(k * 1.1), std::cos(k * 0.7), std::sin(k * 0.37 + 1.0)));
        v.variation = (k % 15 - 7) / 7.0;
        const AcousticVoxel u = unpack(pack(v));
        EXPECT_EQ(u.tissue, v.tissue);
        EXPECT_EQ(u.other, v.border ? v.other : u.other);
        EXPECT_EQ(u.border, v.border);
        EXPECT_NEAR(u.variation, v.variation, 1e-9);
        if (!v.border) continue;
        EXPECT_NEAR(u.near, v.near, 0.5 * double(gpu::kNearRange) / 63.0 + 1e-9);
        EXPECT_GT(glm::dot(u.normal, v.normal), std::cos(0.065));
    }
}

double distanceToBorder(const test::EncodedPatient& patient, const Vec3& p) {
    const Index3 cell = patient.grid.nearest(p);
    const AcousticVoxel v = unpack(patient.voxels[patient.grid.offset(cell)]);
    if (!v.border) return 1e9;
    return (v.near - glm::dot(v.normal, patient.grid.toVoxels(p) - Vec3(cell))) * patient.grid.spacing_m.x;
}

// For a ball: checks the distance of the planes from its surface, and the angle of their normals to the
// radius.
TEST(AcousticVoxels, PlanesFollowASurfaceWithoutSteps) {
    const double radius = 0.015, spacing = 0.001;
    const Vec3 centre(0.0003, -0.0002, 0.0204);
    const patient::Package package = test::soundBlock(Vec3(0.020), 0.040, spacing, [&](const Vec3& p) {
        return glm::length(p - centre) < radius ? "liver" : "fat";
    });
    const patient::Patient patient(package);
    const test::EncodedPatient encoded = test::encode(patient, test::soundTable());
    double worst_m = 0.0, squares = 0.0, turned = 0.0;
    int count = 0;
    for (int k = 0; k < 2000; ++k) {
        const double z = 1.0 - 2.0 * (k + 0.5) / 2000, angle = k * 2.399963;
        const Vec3 out(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
        const Vec3 p = centre + radius * out;
        const Index3 cell = encoded.grid.nearest(p);
        const AcousticVoxel v = unpack(encoded.voxels[encoded.grid.offset(cell)]);
        ASSERT_TRUE(v.border);
        const bool liver = test::soundTable().acoustics[std::size_t(v.tissue)].name == "liver";
        turned += 1.0 - glm::dot(v.normal, liver ? out : -out);
        const double off = distanceToBorder(encoded, p);
        squares += off * off;
        worst_m = std::max(worst_m, std::fabs(off));
        ++count;
    }
    // Voxels alone would have an error of 0.29 voxels (rms) and up to 0.87.
    EXPECT_LT(std::sqrt(squares / count), 0.15 * spacing);
    EXPECT_LT(worst_m, 0.6 * spacing);
    EXPECT_LT(turned / count, 1.0 - std::cos(0.12));
}

TEST(AcousticVoxels, FlatBorderIsLocatedExactly) {
    const patient::Package package = test::soundLayers({{"fat", 0.010}, {"muscle", 0.010}}, 0.020, 0.001);
    const patient::Patient patient(package);
    const test::EncodedPatient encoded = test::encode(patient, test::soundTable());
    for (double x = -0.020; x < 0.020; x += 0.0013) {
        EXPECT_NEAR(distanceToBorder(encoded, Vec3(x, 0.0, 0.0097)), 0.0003, 0.00005);
        EXPECT_NEAR(distanceToBorder(encoded, Vec3(x, 0.0, 0.0103)), 0.0003, 0.00005);
    }
    EXPECT_EQ(distanceToBorder(encoded, Vec3(0.0, 0.0, 0.005)), 1e9);
}

// A membrane one voxel thick keeps its tissue, although a single plane cannot represent it.
TEST(AcousticVoxels, ThinMembraneIsPreserved) {
    const patient::Package package =
        test::soundLayers({{"fat", 0.010}, {"fascia", 0.001}, {"muscle", 0.010}}, 0.020, 0.001);
    const patient::Patient patient(package);
    const test::EncodedPatient encoded = test::encode(patient, test::soundTable());
    const AcousticVoxel v =
        unpack(encoded.voxels[encoded.grid.offset(encoded.grid.nearest(Vec3(0.0, 0.0, 0.0105)))]);
    EXPECT_EQ(test::soundTable().acoustics[std::size_t(v.tissue)].name, "fascia");
    EXPECT_FALSE(v.border);
}

}  // namespace
}  // namespace stylet::render
