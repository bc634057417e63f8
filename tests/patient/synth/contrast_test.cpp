// Tests contrast medium and blood flow in the reference patient.
#include "patient/contrast/contrast.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "patient/contrast/contrast_table.h"
#include "patient/synth/labels.h"
#include "patient/synth/synth.h"
#include "tests/patient/blood_facts.h"
#include "tests/support/constants.h"

namespace stylet::patient::synth {
namespace {

using test::kDt_s;

constexpr double kMl = 1e-6;

class ReferenceLiver : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        SynthSettings settings;
        settings.spacing_m = 0.002;
        if (const char* assets = std::getenv("STYLET_ASSETS"))
            settings.defaults = loadTissueDefaults(std::filesystem::path(assets) / "tissue" / "ptcd.toml");
        package_ = new Package(makeReferencePatient(settings));
    }
    static void TearDownTestSuite() { delete package_; }

    // Centre of the rightmost voxel of a label that is at least `inward_m` from the right side of the grid.
    static Vec3 rightmostVoxel(Id id, double inward_m = 0.0) {
        const Grid& g = package_->labels.grid;
        Index3 best(-1);
        forEachVoxel(g, [&](const Index3& i) {
            if (package_->labels[i] == std::uint8_t(id) && i.x > best.x &&
                double(g.dims.x - i.x) * g.spacing_m.x > inward_m)
                best = i;
        });
        return g.centre(best);
    }
    static double distanceTo(Id id, const Vec3& p) {
        const Grid& g = package_->labels.grid;
        double least = 1.0;
        forEachVoxel(g, [&](const Index3& i) {
            if (package_->labels[i] == std::uint8_t(id))
                least = std::min(least, glm::length(g.centre(i) - p));
        });
        return least;
    }

    static inline Package* package_ = nullptr;
    Patient patient_{*package_};
};

TEST_F(ReferenceLiver, BloodFlowsInAnatomicalDirections) {
    test::expectBloodFlowDirections(patient_);
}

TEST_F(ReferenceLiver, CholangiogramReachesTheTumourThenLeaks) {
    Contrast contrast(patient_);
    const Vec3 tip = rightmostVoxel(Id::ducts);
    double last_front_m = -0.01;
    while (!contrast.status().at_blockage && contrast.volumes().injected_m3 < 30.0 * kMl) {
        contrast.step({tip, 2.0 * kMl, true}, kDt_s);
        EXPECT_GE(contrast.status().front_m, last_front_m);
        last_front_m = contrast.status().front_m;
    }
    EXPECT_TRUE(contrast.status().at_blockage);
    EXPECT_LT(distanceTo(Id::tumour, contrast.status().blockage_reference_m), 0.004);
    EXPECT_GT(contrast.volumes().ducts_m3, 4.0 * kMl) << "most of the tree lies before it";
    EXPECT_EQ(contrast.volumes().liver_m3, 0.0);
    for (int i = 0; i < 10000; ++i)
        contrast.step({tip, 2.0 * kMl, true}, kDt_s);
    const ContrastVolumes& v = contrast.volumes();
    EXPECT_NEAR(v.ducts_m3, contrast.status().tree_m3, 1e-9 * kMl) << "full: the tree is connected";
    EXPECT_GT(v.liver_m3, 0.0);
    EXPECT_NEAR(v.ducts_m3 + v.liver_m3 + v.washed_out_m3, v.injected_m3, 1e-9 * v.injected_m3);
}

TEST_F(ReferenceLiver, DuctTreeMovesWithBreathing) {
    Contrast contrast(patient_);
    const Vec3 tip = rightmostVoxel(Id::ducts);
    for (int i = 0; i < 4000; ++i)
        contrast.step({tip, 2.0 * kMl, true}, kDt_s);
    ContrastPainter painter;
    ContrastChanges changes;
    ContrastTable table;
    ASSERT_TRUE(painter.paint(contrast, changes));
    apply(changes, table);
    const auto middle = [&](const Surrogate& breath) {
        Vec3 sum(0.0);
        double weight = 0.0;
        forEachVoxel(table.grid, [&](const Index3& i) {
            const double value = double(table.added_per_m[table.grid.offset(i)]);
            if (value == 0.0) return;
            sum += value * deformedFromReference(package_->motion, breath, table.grid.centre(i));
            weight += value;
        });
        return sum / weight;
    };
    const Vec3 moved = middle({1.0, 0.0}) - middle({0.0, 0.0});
    EXPECT_LT(moved.z, -0.005) << "toward the feet, breathing in";
    EXPECT_GT(moved.z, -0.025);
}

TEST_F(ReferenceLiver, VesselEmptiesWithinSeconds) {
    for (const Id id : {Id::portal, Id::hepaticVeins}) {
        Contrast contrast(patient_);
        const Vec3 tip = rightmostVoxel(id, 0.110);
        for (int i = 0; i < 2000; ++i)
            contrast.step({tip, 1.0 * kMl, true}, kDt_s);
        EXPECT_EQ(contrast.status().place, ContrastPlace::vessel);
        EXPECT_GT(contrast.volumes().vessels_m3, 0.05 * kMl);
        for (int i = 0; i < 5000; ++i)
            contrast.step({tip, 0.0, true}, kDt_s);
        EXPECT_LT(contrast.volumes().vessels_m3, 0.05 * kMl);
        EXPECT_GT(contrast.volumes().washed_out_m3, 1.95 * kMl);
    }
}

}  // namespace
}  // namespace stylet::patient::synth
