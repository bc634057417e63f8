#include "patient/contrast/contrast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "patient/contrast/contrast_table.h"
#include "tests/patient/contrast_phantom.h"
#include "tests/support/constants.h"

namespace stylet::patient {
namespace {

using test::addLabel;
using test::carve;
using test::idOf;
using test::kDt_s;
using test::liverBlock;
using test::tubeAlongX;

constexpr double kMl = 1e-6;

// No residual bile, and a front as sharp as the voxels allow. Then a volume is an area times a length.
ContrastSettings sharp() {
    ContrastSettings s;
    s.bile_share = 0.0;
    s.duct_front = {0.002, 0.0};
    return s;
}

void inject(Contrast& contrast, const Vec3& tip_m, double ml_per_s, double seconds) {
    for (int i = 0; i < int(std::lround(seconds / kDt_s)); ++i)
        contrast.step({tip_m, ml_per_s * kMl, true}, kDt_s);
}

double accounted(const ContrastVolumes& v) {
    return v.ducts_m3 + v.liver_m3 + v.vessels_m3 + v.pooled_m3 + v.washed_out_m3 + v.lost_m3;
}

ContrastTable makeTable(const Contrast& contrast, ContrastPainter& painter) {
    ContrastTable table;
    ContrastChanges changes;
    if (painter.paint(contrast, changes)) apply(changes, table);
    return table;
}
ContrastTable makeTable(const Contrast& contrast) {
    ContrastPainter painter;
    return makeTable(contrast, painter);
}

// Volume of medium that a table represents, for the settings it was made with.
double shown_m3(const ContrastTable& table, const ContrastSettings& s = {}) {
    double sum = 0.0;
    for (const float v : table.added_per_m)
        sum += double(v);
    return sum * voxelVolume_m3(table.grid) / (s.iodine_kg_per_m3 * s.attenuation_m2_per_kg);
}

double valueAt(const ContrastTable& table, const Vec3& p) {
    const Index3 i = table.grid.nearest(p);
    return table.grid.contains(i) ? double(table.added_per_m[table.grid.offset(i)]) : 0.0;
}

// 3 x 3 voxels of 1 mm along x from 10 to 70 mm: cross-section 9 mm^2, volume 0.54 ml.
constexpr double kArea_m2 = 9e-6;
Package straightDuct() {
    Package package = liverBlock(0.080, 0.001);
    carve(package, idOf(Tissue::duct), tubeAlongX(0.010, 0.070, 0.0016));
    return package;
}
// The centre of the first slice.
const Vec3 kTip{0.0105, 0.0, 0.0};

TEST(ContrastInADuct, FrontIsAtVolumeOverArea) {
    const test::OwnedPatient patient(straightDuct());
    Contrast contrast(patient, sharp());
    inject(contrast, kTip, 0.1, 1.0);
    EXPECT_EQ(contrast.status().place, ContrastPlace::duct);
    EXPECT_NEAR(contrast.volumes().ducts_m3, 0.1 * kMl, 1e-12);
    for (const double more : {0.1, 0.2}) {
        inject(contrast, kTip, more, 1.0);
        const double length_m = contrast.volumes().injected_m3 / kArea_m2;
        // Distances refer to voxel centres, so the front is half a voxel before the end of the filled part. A
        // path to one of the eight outer voxels of a cross-section has a diagonal step. Over the nine voxels
        // this adds 0.51 mm on average.
        EXPECT_NEAR(contrast.status().front_m, length_m - 0.00050 + 0.00051, 0.00002);
        const ContrastTable table = makeTable(contrast);
        EXPECT_NEAR(valueAt(table, {0.0105 + length_m - 0.003, 0, 0}), 75.0, 1e-3) << "full: 0.075 /mm";
        EXPECT_EQ(valueAt(table, {0.0105 + length_m + 0.003, 0, 0}), 0.0);
    }
}

TEST(ContrastInADuct, ResidualBileDilutesTheMedium) {
    const test::OwnedPatient patient(straightDuct());
    ContrastSettings settings = sharp();
    settings.bile_share = 0.5;
    Contrast contrast(patient, settings);
    inject(contrast, kTip, 0.1, 1.0);
    EXPECT_NEAR(contrast.status().front_m, 0.1 * kMl / 0.5 / kArea_m2, 0.00002);
    EXPECT_NEAR(valueAt(makeTable(contrast), {0.015, 0, 0}), 37.5, 1e-3);
}

TEST(ContrastInADuct, FillsBothBranchesEqually) {
    Package package = liverBlock(0.060, 0.001);
    carve(package, idOf(Tissue::duct), [](double x, double y, double z) {
        if (std::abs(z) > 0.0016) return false;
        const bool trunk = x > 0.005 && x < 0.020 && std::abs(y) < 0.0016;
        const bool cross = x > 0.020 && x < 0.023 && std::abs(y) < 0.0116;
        const bool branch = x > 0.023 && x < 0.050 && std::abs(std::abs(y) - 0.010) < 0.0016;
        return trunk || cross || branch;
    });
    const Patient patient(package);
    Contrast contrast(patient, sharp());
    inject(contrast, {0.0055, 0.0, 0.0}, 0.4, 1.0);
    const ContrastTable table = makeTable(contrast);
    EXPECT_NEAR(shown_m3(table, sharp()), 0.4 * kMl, 1e-5 * kMl);
    double near = 0.0, far = 0.0;
    for (int i = 0; i < 27; ++i) {
        const double x = 0.0235 + 0.001 * i;
        EXPECT_NEAR(valueAt(table, {x, -0.010, 0}), valueAt(table, {x, 0.010, 0}), 1e-4) << x;
        (i < 9 ? near : far) += valueAt(table, {x, 0.010, 0});
    }
    EXPECT_GT(near, 0.0);
    EXPECT_LT(far, near);
}

TEST(ContrastInADuct, StopsAtAStrictureThenLeaksIntoTheParenchyma) {
    Package package = straightDuct();
    const std::uint8_t shut = addLabel(package, "stricture", Tissue::duct, Role::pass);
    carve(package, shut, tubeAlongX(0.040, 0.043, 0.0016));
    const Patient patient(package);
    Contrast contrast(patient, sharp());
    inject(contrast, kTip, 0.1, 2.0);
    EXPECT_FALSE(contrast.status().at_blockage);
    inject(contrast, kTip, 0.1, 1.0);
    EXPECT_TRUE(contrast.status().at_blockage);
    EXPECT_NEAR(contrast.status().blockage_reference_m.x, 0.0395, 1e-9);
    EXPECT_NEAR(contrast.volumes().ducts_m3, 30e-3 * kArea_m2, 1e-12) << "30 mm and no more";
    EXPECT_NEAR(contrast.volumes().liver_m3, 0.3 * kMl - 30e-3 * kArea_m2, 1e-3 * kMl);
    EXPECT_NEAR(contrast.status().tree_m3, 30e-3 * kArea_m2, 1e-12);
    const ContrastTable table = makeTable(contrast);
    EXPECT_EQ(valueAt(table, {0.0415, 0, 0}), 0.0);
    EXPECT_EQ(valueAt(table, {0.050, 0, 0}), 0.0);
    EXPECT_GT(valueAt(table, {0.0105, 0.003, 0}), 0.0) << "the leak";
}

TEST(ContrastInADuct, DrainsWhereTheTreeOpensIntoTheBowel) {
    Package package = straightDuct();
    const std::uint8_t bowel = addLabel(package, "hollow organ", Tissue::soft, Role::risk);
    package.label_table.back().drains_ducts = true;
    carve(package, bowel, tubeAlongX(0.070, 0.080, 0.010));
    const Patient patient(package);
    Contrast contrast(patient, sharp());
    inject(contrast, kTip, 0.2, 5.0);
    EXPECT_NEAR(contrast.volumes().ducts_m3, 60e-3 * kArea_m2, 0.02 * kMl);
    EXPECT_NEAR(contrast.volumes().pooled_m3, 1.0 * kMl - contrast.volumes().ducts_m3, 1e-12);
    EXPECT_EQ(contrast.volumes().liver_m3, 0.0);
    EXPECT_FALSE(contrast.status().at_blockage);
}

// Only the role counts: without it, an organ named like the bowel drains nothing.
TEST(ContrastInADuct, DoesNotDrainIntoAnOrganWithoutThatRole) {
    Package package = straightDuct();
    carve(package, addLabel(package, "small bowel", Tissue::soft, Role::risk),
          tubeAlongX(0.070, 0.080, 0.010));
    const Patient patient(package);
    Contrast contrast(patient, sharp());
    inject(contrast, kTip, 0.2, 5.0);
    EXPECT_EQ(contrast.volumes().pooled_m3, 0.0);
    EXPECT_GT(contrast.volumes().liver_m3, 0.0) << "full, so it leaks";
}

// A blocked tree does not drain, even if it also touches the bowel.
TEST(ContrastInADuct, IsBlockedByALabelWithThatRole) {
    Package package = straightDuct();
    const std::uint8_t bowel = addLabel(package, "one", Tissue::soft, Role::risk);
    package.label_table.back().drains_ducts = true;
    carve(package, bowel, tubeAlongX(0.070, 0.080, 0.010));
    const std::uint8_t mass = addLabel(package, "two", Tissue::liver, Role::pass);
    carve(package, mass, tubeAlongX(0.040, 0.050, 0.0045, 0.006));
    for (const bool blocks : {false, true}) {
        package.label_table.back().blocks_contrast = blocks;
        const Patient patient(package);
        Contrast contrast(patient, sharp());
        inject(contrast, kTip, 0.2, 5.0);
        EXPECT_EQ(contrast.volumes().pooled_m3 > 0.0, !blocks);
        EXPECT_EQ(contrast.status().at_blockage, blocks);
    }
}

TEST(ContrastInADuct, EarlierMediumStaysWhenTheTipMoves) {
    const test::OwnedPatient patient(straightDuct());
    Contrast contrast(patient, sharp());
    inject(contrast, kTip, 0.1, 1.0);
    inject(contrast, {0.0605, 0.0, 0.0}, 0.1, 1.0);
    EXPECT_NEAR(contrast.volumes().ducts_m3, 0.2 * kMl, 1e-12);
    const ContrastTable table = makeTable(contrast);
    EXPECT_NEAR(shown_m3(table, sharp()), 0.2 * kMl, 1e-5 * kMl);
    EXPECT_NEAR(valueAt(table, {0.015, 0, 0}), 75.0, 1e-3);
    EXPECT_NEAR(valueAt(table, {0.0605, 0, 0}), 75.0, 1e-3);
    EXPECT_EQ(valueAt(table, {0.040, 0, 0}), 0.0);
    inject(contrast, {0.0605, 0.0, 0.0}, 0.1, 10.0);
    EXPECT_NEAR(contrast.volumes().ducts_m3, 60e-3 * kArea_m2, 1e-9 * kMl) << "full, as without the move";
}

TEST(ContrastInTheLiver, FillsABallOfExtracellularSpaceAndFades) {
    const test::OwnedPatient patient(liverBlock(0.080, 0.001));
    ContrastSettings settings;
    settings.stain_front = {0.002, 0.0};
    Contrast contrast(patient, settings);
    const Vec3 tip(0.0403, 0.0002, -0.0004);
    inject(contrast, tip, 1.0, 1.0);
    EXPECT_EQ(contrast.status().place, ContrastPlace::liver);
    const double radius_m = std::cbrt(1.0 * kMl / (settings.liver_porosity * 4.0 / 3.0 * M_PI));
    ContrastPainter painter({0.0});
    const ContrastTable table = makeTable(contrast, painter);
    for (const Vec3 direction : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, 0.0, 0.8)}) {
        EXPECT_GT(valueAt(table, tip + direction * (radius_m - 0.002)), 0.2 * 75.0 * settings.liver_porosity);
        EXPECT_EQ(valueAt(table, tip + direction * (radius_m + 0.002)), 0.0);
    }
    EXPECT_NEAR(shown_m3(table), contrast.volumes().liver_m3, 1e-4 * kMl);
    const double before = contrast.volumes().liver_m3;
    inject(contrast, tip, 0.0, 60.0);
    EXPECT_NEAR(contrast.volumes().liver_m3, before * std::exp(-60.0 / settings.stain_fade_s), 1e-6 * kMl);
    EXPECT_NEAR(accounted(contrast.volumes()), 1.0 * kMl, 1e-12 * kMl);
}

// A vessel of 1.5 m along x with 3 x 3 voxels of 4 mm. The blood needs longer to pass through it than a plume
// is simulated.
Package longVessel() {
    Package package = liverBlock(1.6, 0.004);
    carve(package, idOf(Tissue::vessel), tubeAlongX(0.04, 1.56, 0.0061));
    return package;
}

// A tip that advances slowly stains new tissue. No voxel may contain more medium than its extracellular
// space.
TEST(ContrastInTheLiver, SlowlyMovingTipWidensTheStain) {
    const test::OwnedPatient patient(liverBlock(0.080, 0.001));
    const ContrastSettings settings;
    Contrast contrast(patient);
    for (int i = 0; i < 3; ++i)
        inject(contrast, Vec3(0.040 + 0.0031 * i, 0.0, 0.0), 1.0, 3.0);
    const ContrastTable table = makeTable(contrast);
    const double full_per_m =
        settings.liver_porosity * settings.iodine_kg_per_m3 * settings.attenuation_m2_per_kg;
    double most_per_m = 0.0;
    for (const float added : table.added_per_m)
        most_per_m = std::max(most_per_m, double(added));
    EXPECT_LE(most_per_m, 1.001 * full_per_m);
    EXPECT_GT(most_per_m, 0.8 * full_per_m);
    EXPECT_NEAR(shown_m3(table), contrast.volumes().liver_m3, 0.01 * contrast.volumes().liver_m3);
}

// A tip in a part of a duct that is closed at both ends leaks. The duct tree beside it stays empty.
TEST(ContrastInADuct, LeaksFromAClosedDuctIntoTheSurroundings) {
    Package package = straightDuct();
    carve(package, addLabel(package, "stricture", Tissue::duct, Role::pass),
          tubeAlongX(0.040, 0.043, 0.0016));
    const Patient patient(package);
    Contrast contrast(patient);
    inject(contrast, {0.0415, 0.0, 0.0}, 0.5, 1.0);
    EXPECT_EQ(contrast.volumes().ducts_m3, 0.0);
    EXPECT_NEAR(accounted(contrast.volumes()), 0.5 * kMl, 1e-12);
    EXPECT_EQ(valueAt(makeTable(contrast), {0.0250, 0.0, 0.0}), 0.0);
}

TEST(ContrastInAVessel, FlowsWithTheBloodAndWashesOutExponentially) {
    const test::OwnedPatient patient(longVessel());
    const ContrastSettings settings;
    Contrast contrast(patient, settings);
    const Vec3 tip(0.202, 0.0, 0.0);
    inject(contrast, tip, 2.0, 0.05);
    EXPECT_EQ(contrast.status().place, ContrastPlace::vessel);
    const double before = contrast.volumes().vessels_m3;
    EXPECT_NEAR(before, 0.1 * kMl, 0.002 * kMl);
    inject(contrast, tip, 0.0, 2.0);
    EXPECT_NEAR(contrast.volumes().vessels_m3, before * std::exp(-2.0 / settings.vessel_washout_s),
                1e-4 * kMl);
    const ContrastTable table = makeTable(contrast);
    EXPECT_NEAR(shown_m3(table), contrast.volumes().vessels_m3, 1e-4 * kMl);
    double sum = 0.0, first = 0.0, upstream = 0.0;
    forEachVoxel(table.grid, [&](const Index3& i) {
        const double value = double(table.added_per_m[table.grid.offset(i)]);
        const double at_m = table.grid.centre(i).x;
        sum += value, first += value * at_m;
        if (at_m < 0.19) upstream += value;
    });
    const double mean_m_per_s = VesselFlowSettings{}.trunk_m_per_s[std::size_t(BloodKind::other)];
    EXPECT_NEAR(first / sum, 0.202 + 2.0 * mean_m_per_s, 0.05 * mean_m_per_s + 0.004);
    EXPECT_EQ(upstream, 0.0);
    inject(contrast, tip, 0.0, 60.0);
    EXPECT_EQ(contrast.volumes().vessels_m3, 0.0);
    EXPECT_TRUE(contrast.plumes().empty());
    EXPECT_NEAR(accounted(contrast.volumes()), 0.1 * kMl, 1e-12 * kMl);
}

TEST(ContrastInAVessel, ExcessVolumeLeavesTheVesselAtOnce) {
    Package package = liverBlock(0.080, 0.001);
    carve(package, idOf(Tissue::vessel), tubeAlongX(0.010, 0.030, 0.0006));  // 1 mm^2, 0.02 ml
    const Patient patient(package);
    Contrast contrast(patient);
    inject(contrast, {0.0155, 0.0, 0.0}, 10.0, 1.0);
    EXPECT_LE(contrast.volumes().vessels_m3, 0.02 * kMl);
    EXPECT_NEAR(accounted(contrast.volumes()), 10.0 * kMl, 1e-9 * kMl);
    for (const float value : makeTable(contrast).added_per_m)
        EXPECT_LE(value, 75.0f * 1.0001f);
}

TEST(ContrastElsewhere, IsAPoolOrLost) {
    const test::OwnedPatient patient(
        test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.040}, {Tissue::liver, 0.040}}, 0.001));
    Contrast contrast(patient);
    inject(contrast, {0.020, 0.0, 0.0}, 1.0, 1.0);
    EXPECT_EQ(contrast.status().place, ContrastPlace::elsewhere);
    EXPECT_NEAR(contrast.volumes().pooled_m3, 1.0 * kMl, 1e-12);
    EXPECT_NEAR(shown_m3(makeTable(contrast)), 1.0 * kMl, 1e-4 * kMl);
    for (int i = 0; i < 1000; ++i)
        contrast.step({{0.020, 0.0, 0.0}, 1.0 * kMl, false}, kDt_s);
    EXPECT_EQ(contrast.status().place, ContrastPlace::outside);
    inject(contrast, {5.0, 0.0, 0.0}, 1.0, 1.0);
    EXPECT_NEAR(contrast.volumes().lost_m3, 2.0 * kMl, 1e-12);
    EXPECT_NEAR(accounted(contrast.volumes()), 3.0 * kMl, 1e-9 * kMl);
}

TEST(Contrast, IgnoresInvalidRatesAndPositions) {
    const test::OwnedPatient patient(straightDuct());
    Contrast contrast(patient);
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    for (const double rate : {nan, -1.0, -inf, 0.0})
        contrast.step({kTip, rate, true}, kDt_s);
    EXPECT_FALSE(contrast.begun());
    EXPECT_EQ(contrast.hash(), Contrast(patient).hash());
    contrast.step({kTip, inf, true}, kDt_s);
    EXPECT_NEAR(contrast.volumes().injected_m3, ContrastSettings{}.max_m3_per_s * kDt_s, 1e-15);
    for (const double bad : {nan, inf, -inf, 1e300, -1e9})
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 tip = kTip;
            tip[axis] = bad;
            contrast.step({tip, 1.0 * kMl, true}, kDt_s);
            EXPECT_EQ(contrast.status().place, ContrastPlace::outside);
        }
    EXPECT_NEAR(accounted(contrast.volumes()), contrast.volumes().injected_m3, 1e-18);
}

// Withdraws a needle through all tissues while it injects.
void wander(Contrast& contrast, ContrastPainter* painter, ContrastTable* table) {
    ContrastChanges changes;
    for (int i = 0; i < 6000; ++i) {
        const double rate = i % 1500 < 1200 ? 1.5 * kMl : 0.0;
        contrast.step({{0.072 - 1.1e-5 * i, 0.0003, 1e-6 * (i % 7)}, rate, i < 5500}, kDt_s);
        if (painter && i % 10 == 0 && painter->paint(contrast, changes)) apply(changes, *table);
    }
}
Package mixed() {
    Package package = straightDuct();
    carve(package, idOf(Tissue::vessel), tubeAlongX(0.030, 0.036, 0.010));
    carve(package, idOf(Tissue::soft), tubeAlongX(0.0, 0.012, 0.020));
    return package;
}

// HZ-TEACH-16
TEST(Contrast, VolumeIsConservedAndHashIsReproducible) {
    const test::OwnedPatient patient(mixed());
    Contrast first(patient), second(patient);
    wander(first, nullptr, nullptr);
    wander(second, nullptr, nullptr);
    const ContrastVolumes& v = first.volumes();
    EXPECT_NEAR(accounted(v), v.injected_m3, 1e-9 * v.injected_m3);
    for (const double part : {v.ducts_m3, v.liver_m3, v.pooled_m3, v.washed_out_m3, v.lost_m3})
        EXPECT_GT(part, 0.0);
    EXPECT_EQ(first.hash(), second.hash());
    second.step({kTip, 0.0, true}, kDt_s);
    EXPECT_NE(first.hash(), second.hash());
}

TEST(ContrastTable, IncrementalTableEqualsAFreshOneAndConservesVolume) {
    const test::OwnedPatient patient(mixed());
    Contrast contrast(patient);
    ContrastPainter painter({0.0});
    ContrastTable kept;
    wander(contrast, &painter, &kept);
    ContrastChanges changes;
    if (painter.paint(contrast, changes)) apply(changes, kept);
    const ContrastTable fresh = makeTable(contrast);
    const ContrastVolumes& v = contrast.volumes();
    const double volume_m3 = v.ducts_m3 + v.liver_m3 + v.vessels_m3 + v.pooled_m3;
    EXPECT_NEAR(shown_m3(kept), volume_m3, 0.001 * volume_m3);
    forEachVoxel(patient.grid(), [&](const Index3& i) {
        const Vec3 p = patient.grid().centre(i);
        ASSERT_NEAR(valueAt(kept, p), valueAt(fresh, p), 1e-3) << i.x << ' ' << i.y << ' ' << i.z;
    });
    EXPECT_GT(kept.revision, 10u);
}

TEST(ContrastTable, ResetMakesTheNextUpdateComplete) {
    const test::OwnedPatient patient(mixed());
    Contrast contrast(patient);
    ContrastPainter painter({0.0});
    ContrastTable kept, late;
    wander(contrast, &painter, &kept);
    ContrastChanges changes;
    if (painter.paint(contrast, changes)) apply(changes, kept);
    painter.reset();
    ASSERT_TRUE(painter.paint(contrast, changes));
    EXPECT_TRUE(changes.whole);
    apply(changes, late);
    EXPECT_EQ(late.grid, kept.grid);
    EXPECT_EQ(late.added_per_m, kept.added_per_m);
    EXPECT_GT(late.revision, kept.revision);
}

TEST(ContrastTable, UpdatesOnlyOnAVisibleChange) {
    const test::OwnedPatient patient(straightDuct());
    Contrast contrast(patient);
    ContrastPainter coarse({0.05 * kMl}), every({0.0});
    ContrastChanges changes;
    EXPECT_FALSE(coarse.paint(contrast, changes)) << "no medium, no table";
    int coarse_count = 0, every_count = 0;
    for (int i = 0; i < 200; ++i) {
        contrast.step({kTip, 1.0 * kMl, true}, kDt_s);
        coarse_count += coarse.paint(contrast, changes);
        every_count += every.paint(contrast, changes);
    }
    EXPECT_EQ(every_count, 200);
    EXPECT_GE(coarse_count, 3);
    EXPECT_LE(coarse_count, 5);
    EXPECT_EQ(coarse.skipped(), 201u - std::uint64_t(coarse_count));
    contrast.step({kTip, 0.0, true}, kDt_s);
    EXPECT_FALSE(every.paint(contrast, changes)) << "nothing moved";
}

}  // namespace
}  // namespace stylet::patient
