// A coarse reference patient is plausible. Every defect added to it is found, and packages that cannot be
// simulated are refused.
#include "app/modeller/check/check_package.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "app/modeller/image/voxel_tools.h"
#include "patient/synth/labels.h"
#include "tests/app/modeller/reference_patient.h"

namespace stylet::modeller {
namespace {

using patient::Package;
using patient::Tissue;
using patient::synth::Id;

const Package& referencePatient() {
    static const Package package = test::referencePatient(1, 0.003);
    return package;
}

std::string formatAll(const std::vector<Finding>& findings) {
    std::string all;
    for (const Finding& f : findings)
        all += formatFinding(f) + "\n";
    return all;
}

// Applies `corrupt` to the good patient, which has no motion here to save time. Expects a finding about
// `what` with this value of `refused`.
template <typename Corrupt>
void expectFound(Corrupt corrupt, const std::string& what, bool refused) {
    Package p = referencePatient();
    p.motion = {};
    corrupt(p);
    const std::vector<Finding> findings = checkPackage(p);
    const auto found = std::find_if(findings.begin(), findings.end(),
                                    [&](const Finding& f) { return f.what == what && f.refused == refused; });
    EXPECT_NE(found, findings.end()) << "wanted " << what << ", refused " << refused << ", got\n"
                                     << formatAll(findings);
    EXPECT_EQ(anyRefused(findings), refused) << formatAll(findings);
    for (const Finding& f : findings) {
        EXPECT_FALSE(f.value.empty() || f.expected.empty() || f.reason.empty()) << formatFinding(f);
        EXPECT_THAT(formatFinding(f), testing::Not(testing::HasSubstr("\n")));
    }
}

// Replaces all voxels with the ids `from` by `to`.
auto relabel(std::initializer_list<Id> from, Id to) {
    return [set = patient::synth::anyOf(from), to](Package& p) {
        for (std::uint8_t& id : p.labels.voxels)
            if (patient::synth::contains(set, id)) id = std::uint8_t(to);
    };
}

auto shiftValues(std::initializer_list<Id> ids, int hu) {
    return [set = patient::synth::anyOf(ids), hu](Package& p) {
        for (std::size_t i = 0; i < p.ct.voxels.size(); ++i)
            if (patient::synth::contains(set, p.labels.voxels[i]))
                p.ct.voxels[i] = std::int16_t(p.ct.voxels[i] + hu);
    };
}

// Crops `low` voxels at the start of each axis and `high` voxels at its end.
auto crop(Index3 low, Index3 high) {
    return [low, high](Package& p) {
        const VoxelBox box{low, p.ct.grid.dims - 1 - high};
        p.ct = cropped(p.ct, box);
        p.labels = cropped(p.labels, box);
    };
}

// Flips the voxels along one axis. The grid is unchanged.
auto mirror(int axis) {
    return [axis](Package& p) {
        const Package old = p;
        const Grid& g = p.ct.grid;
        forEachVoxel(g, [&](const Index3& i) {
            Index3 from = i;
            from[axis] = g.dims[axis] - 1 - from[axis];
            p.ct[i] = old.ct[from];
            p.labels[i] = old.labels[from];
        });
    };
}

// Lowest and highest slice of the liver.
std::pair<int, int> liverHeights() {
    const LabelVolume& labels = referencePatient().labels;
    const VoxelBox box = boundingBox(
        maskWhere(labels.grid, [&](std::size_t i) { return labels.voxels[i] == std::uint8_t(Id::liver); }));
    return {box.low.z, box.high.z};
}

TEST(CheckPackage, PlausiblePatientPasses) {
    const std::vector<Finding> findings = checkPackage(referencePatient());
    EXPECT_FALSE(anyRefused(findings)) << formatAll(findings);
    for (const Finding& f : findings)  // voxels of 3 mm are coarse
        EXPECT_EQ(f.what.rfind("voxel size in ", 0), 0u) << formatFinding(f);
    EXPECT_EQ(formatAll(checkPackage(referencePatient(), 1)), formatAll(findings));
}

// HZ-TEACH-08
TEST(CheckPackage, MissingStructuresAreReported) {
    expectFound(relabel({Id::skin}, Id::fat), "skin", true);
    expectFound(relabel({Id::liver, Id::tumour}, Id::spleen), "liver", true);
    expectFound(relabel({Id::fascia}, Id::muscle), "fascia", true);
    expectFound(relabel({Id::lungRight, Id::lungLeft}, Id::gas), "lungs", true);
    expectFound(relabel({Id::lungLeft}, Id::gas), "left lung", false);
    expectFound(relabel({Id::ducts}, Id::liver), "bile ducts", false);
    expectFound([](Package& p) { p.labels.voxels.pop_back(); }, "image", true);
    expectFound([](Package& p) { p = {}; }, "image", true);
}

TEST(CheckPackage, OpenFasciaIsRefused) {
    // An opening of 30 mm in the right flank, at the height of the liver.
    const auto [low, high] = liverHeights();
    const double middle_z = 0.5 * (low + high);
    expectFound(
        [&](Package& p) {
            const Grid& g = p.labels.grid;
            const VoxelBox opening{{g.dims.x / 2, g.dims.y / 2 - 5, int(middle_z) - 5},
                                   {g.dims.x - 1, g.dims.y / 2 + 5, int(middle_z) + 5}};
            forEachVoxel(opening, [&](const Index3& i) {
                if (p.labels[i] == std::uint8_t(Id::fascia)) p.labels[i] = std::uint8_t(Id::muscle);
            });
        },
        "fascia", true);
}

// No needle reaches the liver from the far side of the spine, so a hole there is only reported.
TEST(CheckPackage, UnreachableFasciaHoleIsOnlyAWarning) {
    expectFound(
        [](Package& p) {
            const Grid& g = p.labels.grid;
            const VoxelBox hole{{0, 0, g.dims.z - 2}, {g.dims.x / 4 - 1, g.dims.y - 1, g.dims.z - 2}};
            forEachVoxel(hole, [&](const Index3& i) {
                if (p.labels[i] == std::uint8_t(Id::fascia)) p.labels[i] = std::uint8_t(Id::muscle);
            });
        },
        "fascia", false);
}

TEST(CheckPackage, UnknownLabelsAndBadTissueParametersAreReported) {
    expectFound([](Package& p) { p.labels.voxels[p.labels.voxels.size() / 2] = 200; }, "label 200", true);
    const auto row = [](Tissue t) { return std::size_t(t); };
    expectFound([&](Package& p) { p.tissues[row(Tissue::liver)].stiffness_n_per_m = 0.0; },
                "tissue liver, stiffness_n_per_m", true);
    expectFound([&](Package& p) { p.tissues[row(Tissue::duct)].cut_force_n = 0.0; },
                "tissue duct, cut_force_n", true);
    expectFound([&](Package& p) { p.elasticity[row(Tissue::skin)].young_pa = 0.0; }, "tissue skin, young_pa",
                true);
    expectFound([](Package& p) { p.thresholds.t1_hu = p.thresholds.t0_hu; }, "threshold t1 above t0", true);
    expectFound([](Package& p) { p.thresholds.t2_specific_hu = p.thresholds.t2_sensitive_hu - 1.0; },
                "threshold t2 past the fascia, above the one outside", true);
    expectFound([](Package& p) { p.thresholds.t2_sensitive_hu = p.thresholds.t2_specific_hu = 120.0; },
                "threshold of bone past the fascia", false);
}

TEST(CheckPackage, HuOutsideTheTissueRangeIsRefused) {
    expectFound(shiftValues({Id::liver, Id::tumour}, 300), "mean of liver", true);
    expectFound(shiftValues({Id::liver, Id::tumour}, -250), "mean of liver", true);
    expectFound(shiftValues({Id::ribsRight, Id::ribsLeft, Id::spine, Id::sternum, Id::cartilage}, 2000),
                "mean of bone", true);
    expectFound(shiftValues({Id::lungRight, Id::lungLeft}, 700), "mean of lungs", true);
}

TEST(CheckPackage, LiverVolumeOutsideTheAdultRangeIsRefused) {
    const auto scale = [](double factor) {
        return [factor](Package& p) {
            for (Grid* g : {&p.ct.grid, &p.labels.grid})
                g->spacing_m *= factor, g->origin_m *= factor;
        };
    };
    expectFound(scale(0.7), "liver volume", true);
    expectFound(scale(1.5), "liver volume", true);
    expectFound(
        [](Package& p) {
            for (Grid* g : {&p.ct.grid, &p.labels.grid})
                g->spacing_m.z = 0.006;
        },
        "voxel size in z", true);
}

// HZ-TEACH-08
TEST(CheckPackage, CroppedLiverOrBodyIsRefused) {
    const auto [low, high] = liverHeights();
    const int above = referencePatient().ct.grid.dims.z - 1 - high;
    expectFound(crop({0, 0, low + 12}, {0, 0, 0}), "liver in the lowest slice", true);
    expectFound(crop({0, 0, 0}, {0, 0, above + 12}), "liver in the highest slice", true);
    expectFound(crop({0, 0, low + 1}, {0, 0, 0}), "liver in the lowest slice", false);
    expectFound(crop({0, 0, 0}, {referencePatient().ct.grid.dims.x / 4, 0, 0}), "liver at the image's sides",
                true);
    // The right flank extends 6 mm beyond the scan.
    int flank = 0;
    const Grid& g = referencePatient().ct.grid;
    for (std::size_t i = 0; i < referencePatient().labels.voxels.size(); ++i)
        if (referencePatient().labels.voxels[i] != 0) flank = std::max(flank, int(i % std::size_t(g.dims.x)));
    expectFound(crop({0, 0, 0}, {g.dims.x - flank + 1, 0, 0}), "body at the image's right side", false);
    // The body reaches all four sides of the image.
    expectFound(
        [](Package& p) {
            for (std::size_t i = 0; i < p.labels.voxels.size(); ++i)
                if (p.labels.voxels[i] == 0) p.labels.voxels[i] = std::uint8_t(Id::fat);
        },
        "body at the image's four sides", true);
}

// HZ-TEACH-03
TEST(CheckPackage, MirroredPatientsAreRefused) {
    expectFound(mirror(0), "liver to the right of the body's middle", true);
    expectFound(mirror(1), "liver in front of the spine", true);
    expectFound(mirror(2), "lungs above the liver", true);
}

// HZ-TEACH-08
TEST(CheckPackage, FoldingMotionIsRefused) {
    expectFound(
        [](Package& p) {
            p.motion = referencePatient().motion;
            for (auto* field : {&p.motion.wall, &p.motion.slide})
                for (patient::MotionCoefficients& c : *field)
                    for (int d = 0; d < 3; ++d)
                        c.a1_m[std::size_t(d)] *= 40.0f;
        },
        "motion", true);
    expectFound(
        [](Package& p) {
            p.motion = referencePatient().motion;
            p.motion.slide.pop_back();
        },
        "motion", true);
    expectFound([](Package&) {}, "motion", false);
}

TEST(CheckPackage, UnreachableDuctsAreAWarning) {
    // One short duct at the far end of the left lobe.
    expectFound(
        [](Package& p) {
            relabel({Id::ducts}, Id::liver)(p);
            const Grid& g = p.labels.grid;
            Index3 leftmost{g.dims};
            forEachVoxel(g, [&](const Index3& i) {
                if (i.x < leftmost.x && p.labels[i] == std::uint8_t(Id::liver)) leftmost = i;
            });
            for (int x = 0; x < 4; ++x)
                p.labels[leftmost + Index3{x, 0, 0}] = std::uint8_t(Id::ducts);
        },
        "planned paths", false);
}

TEST(CheckPackage, FindingIsFormattedOnOneLine) {
    EXPECT_EQ(formatFinding({true, "liver volume", "245 ml", "600 to 3500 ml", "adults"}),
              "REFUSED  liver volume: 245 ml, expected 600 to 3500 ml (adults)");
    EXPECT_EQ(formatFinding({false, "motion", "none", "a model", "no breath"}),
              "look     motion: none, expected a model (no breath)");
}

}  // namespace
}  // namespace stylet::modeller
