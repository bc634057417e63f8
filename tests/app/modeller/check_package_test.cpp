// A coarse reference patient is plausible. Every defect added to it is found, and packages that cannot be
// simulated are refused.
#include "app/modeller/check/check_package.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "patient/synth/labels.h"
#include "patient/synth/synth.h"
#include "tests/support/phantom.h"

namespace stylet::modeller {
namespace {

using patient::Package;
using patient::Tissue;
using patient::synth::Id;

const Package& good() {
    static const Package package = [] {
        patient::synth::SynthSettings s;
        s.seed = 1;
        s.spacing_m = 0.003;
        s.defaults = test::tissueDefaults();
        return patient::synth::makeReferencePatient(s);
    }();
    return package;
}

std::string allOf(const std::vector<Finding>& findings) {
    std::string all;
    for (const Finding& f : findings)
        all += lineOf(f) + "\n";
    return all;
}

// Applies `spoil` to the good patient without motion, to save time. Expects a finding about `what` that is
// refused or not.
template <typename Spoil>
void expectFound(Spoil spoil, const std::string& what, bool refused) {
    Package p = good();
    p.motion = {};
    spoil(p);
    const std::vector<Finding> findings = checkPackage(p);
    const auto found = std::find_if(findings.begin(), findings.end(),
                                    [&](const Finding& f) { return f.what == what && f.refused == refused; });
    EXPECT_NE(found, findings.end()) << "wanted " << what << ", refused " << refused << ", got\n"
                                     << allOf(findings);
    EXPECT_EQ(anyRefused(findings), refused) << allOf(findings);
    for (const Finding& f : findings) {
        EXPECT_FALSE(f.value.empty() || f.expected.empty() || f.reason.empty()) << lineOf(f);
        EXPECT_EQ(lineOf(f).find('\n'), std::string::npos);
    }
}

// Replaces all voxels with the ids `from` by `to`.
auto relabel(std::initializer_list<Id> from, Id to) {
    return [set = patient::synth::anyOf(from), to](Package& p) {
        for (std::uint8_t& id : p.labels.voxels)
            if (patient::synth::holds(set, id)) id = std::uint8_t(to);
    };
}

auto shiftValues(std::initializer_list<Id> ids, int hu) {
    return [set = patient::synth::anyOf(ids), hu](Package& p) {
        for (std::size_t i = 0; i < p.ct.voxels.size(); ++i)
            if (patient::synth::holds(set, p.labels.voxels[i]))
                p.ct.voxels[i] = std::int16_t(p.ct.voxels[i] + hu);
    };
}

// Crops `low` voxels at the start and `high` voxels at the end of each axis.
auto crop(Index3 low, Index3 high) {
    return [low, high](Package& p) {
        const Grid old = p.ct.grid;
        const Grid g{old.dims - low - high, old.spacing_m, old.centre(low)};
        CtVolume ct(g);
        LabelVolume labels(g);
        for (int z = 0; z < g.dims.z; ++z)
            for (int y = 0; y < g.dims.y; ++y)
                for (int x = 0; x < g.dims.x; ++x) {
                    ct[{x, y, z}] = p.ct[low + Index3{x, y, z}];
                    labels[{x, y, z}] = p.labels[low + Index3{x, y, z}];
                }
        p.ct = std::move(ct);
        p.labels = std::move(labels);
    };
}

// Flips the voxels along one axis. The grid is unchanged.
auto mirror(int axis) {
    return [axis](Package& p) {
        const Package old = p;
        const Grid& g = p.ct.grid;
        for (int z = 0; z < g.dims.z; ++z)
            for (int y = 0; y < g.dims.y; ++y)
                for (int x = 0; x < g.dims.x; ++x) {
                    Index3 from{x, y, z};
                    from[axis] = g.dims[axis] - 1 - from[axis];
                    p.ct[{x, y, z}] = old.ct[from];
                    p.labels[{x, y, z}] = old.labels[from];
                }
    };
}

// Lowest and highest slice of the liver.
std::pair<int, int> liverHeights() {
    const Grid& g = good().labels.grid;
    int low = g.dims.z, high = -1;
    for (std::size_t i = 0; i < good().labels.voxels.size(); ++i)
        if (good().labels.voxels[i] == std::uint8_t(Id::liver)) {
            const int z = int(i / (std::size_t(g.dims.x) * std::size_t(g.dims.y)));
            low = std::min(low, z), high = std::max(high, z);
        }
    return {low, high};
}

TEST(CheckPackage, APlausiblePatientIsNotRefused) {
    const std::vector<Finding> findings = checkPackage(good());
    EXPECT_FALSE(anyRefused(findings)) << allOf(findings);
    for (const Finding& f : findings)  // 3 mm is coarse
        EXPECT_EQ(f.what.rfind("voxel size in ", 0), 0u) << lineOf(f);
    EXPECT_EQ(allOf(checkPackage(good(), 1)), allOf(findings));
}

// HZ-TEACH-08
TEST(CheckPackage, WhatAPunctureNeedsMustBeThere) {
    expectFound(relabel({Id::skin}, Id::fat), "skin", true);
    expectFound(relabel({Id::liver, Id::tumour}, Id::spleen), "liver", true);
    expectFound(relabel({Id::fascia}, Id::muscle), "fascia", true);
    expectFound(relabel({Id::lungRight, Id::lungLeft}, Id::gas), "lungs", true);
    expectFound(relabel({Id::lungLeft}, Id::gas), "left lung", false);
    expectFound(relabel({Id::ducts}, Id::liver), "bile ducts", false);
    expectFound([](Package& p) { p.labels.voxels.pop_back(); }, "image", true);
    expectFound([](Package& p) { p = {}; }, "image", true);
}

TEST(CheckPackage, AnOpenFasciaIsRefused) {
    // An opening of 30 mm in the right flank, at the height of the liver.
    const auto [low, high] = liverHeights();
    const double middle_z = 0.5 * (low + high);
    expectFound(
        [&](Package& p) {
            const Grid& g = p.labels.grid;
            for (int z = int(middle_z) - 5; z <= int(middle_z) + 5; ++z)
                for (int y = g.dims.y / 2 - 5; y <= g.dims.y / 2 + 5; ++y)
                    for (int x = g.dims.x / 2; x < g.dims.x; ++x)
                        if (p.labels[{x, y, z}] == std::uint8_t(Id::fascia))
                            p.labels[{x, y, z}] = std::uint8_t(Id::muscle);
        },
        "fascia", true);
}

// No needle reaches the liver from the far side of the spine, so a hole there is only reported.
TEST(CheckPackage, AHoleThatNoNeedleReachesIsOnlyNoted) {
    expectFound(
        [](Package& p) {
            const Grid& g = p.labels.grid;
            const int z = g.dims.z - 2;
            for (int x = 0; x < g.dims.x / 4; ++x)
                for (int y = 0; y < g.dims.y; ++y)
                    if (p.labels[{x, y, z}] == std::uint8_t(Id::fascia))
                        p.labels[{x, y, z}] = std::uint8_t(Id::muscle);
        },
        "fascia", false);
}

TEST(CheckPackage, LabelsAndTissuesMustBeKnown) {
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

TEST(CheckPackage, ValuesMustBeOfTheirTissue) {
    expectFound(shiftValues({Id::liver, Id::tumour}, 300), "mean of liver", true);
    expectFound(shiftValues({Id::liver, Id::tumour}, -250), "mean of liver", true);
    expectFound(shiftValues({Id::ribsRight, Id::ribsLeft, Id::spine, Id::sternum, Id::cartilage}, 2000),
                "mean of bone", true);
    expectFound(shiftValues({Id::lungRight, Id::lungLeft}, 700), "mean of lungs", true);
}

TEST(CheckPackage, TheLiversVolumeIsAnAdults) {
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
TEST(CheckPackage, ACropThroughTheLiverOrTheBodyIsRefused) {
    const auto [low, high] = liverHeights();
    const int above = good().ct.grid.dims.z - 1 - high;
    expectFound(crop({0, 0, low + 12}, {0, 0, 0}), "liver in the lowest slice", true);
    expectFound(crop({0, 0, 0}, {0, 0, above + 12}), "liver in the highest slice", true);
    expectFound(crop({0, 0, low + 1}, {0, 0, 0}), "liver in the lowest slice", false);
    expectFound(crop({0, 0, 0}, {good().ct.grid.dims.x / 4, 0, 0}), "liver at the image's sides", true);
    // The right flank extends 6 mm beyond the scan.
    int flank = 0;
    const Grid& g = good().ct.grid;
    for (std::size_t i = 0; i < good().labels.voxels.size(); ++i)
        if (good().labels.voxels[i] != 0) flank = std::max(flank, int(i % std::size_t(g.dims.x)));
    expectFound(crop({0, 0, 0}, {g.dims.x - flank + 1, 0, 0}), "body at the image's right side", false);
    // Body up to all four sides of the image.
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
TEST(CheckPackage, AMotionThatFoldsIsRefused) {
    expectFound(
        [](Package& p) {
            p.motion = good().motion;
            for (auto* field : {&p.motion.wall, &p.motion.slide})
                for (patient::MotionCoefficients& c : *field)
                    for (int d = 0; d < 3; ++d)
                        c.a1_m[std::size_t(d)] *= 40.0f;
        },
        "motion", true);
    expectFound(
        [](Package& p) {
            p.motion = good().motion;
            p.motion.slide.pop_back();
        },
        "motion", true);
    expectFound([](Package&) {}, "motion", false);
}

TEST(CheckPackage, DuctsOutOfReachAreNoted) {
    // One short duct at the far end of the left lobe.
    expectFound(
        [](Package& p) {
            relabel({Id::ducts}, Id::liver)(p);
            const Grid& g = p.labels.grid;
            Index3 leftmost{g.dims};
            for (int z = 0; z < g.dims.z; ++z)
                for (int y = 0; y < g.dims.y; ++y)
                    for (int x = 0; x < leftmost.x; ++x)
                        if (p.labels[{x, y, z}] == std::uint8_t(Id::liver)) leftmost = {x, y, z};
            for (int x = 0; x < 4; ++x)
                p.labels[leftmost + Index3{x, 0, 0}] = std::uint8_t(Id::ducts);
        },
        "planned paths", false);
}

TEST(CheckPackage, ALineSaysWhatWhyAndWhatToExpect) {
    EXPECT_EQ(lineOf({true, "liver volume", "245 ml", "600 to 3500 ml", "adults"}),
              "REFUSED  liver volume: 245 ml, expected 600 to 3500 ml (adults)");
    EXPECT_EQ(lineOf({false, "motion", "none", "a model", "no breath"}),
              "look     motion: none, expected a model (no breath)");
}

}  // namespace
}  // namespace stylet::modeller
