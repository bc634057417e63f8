#include "patient/tissue/tissue.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/phantom.h"

namespace stylet::patient {
namespace {

constexpr TrackFlags kOutside{false, false}, kPastSkin{true, false}, kPastFascia{true, true};

// One voxel with the given CT value and label.
Package oneVoxel(int ct_hu, std::uint8_t label = 0) {
    Package p = test::makeSlabs({{Tissue::soft, 0.001}}, 0.001);
    Grid grid;
    grid.dims = {1, 1, 1};
    p.ct = CtVolume(grid, std::int16_t(ct_hu));
    p.labels = LabelVolume(grid, label);
    return p;
}

TissueSample sampleVoxel(int ct_hu, TrackFlags flags, std::uint8_t label = 0) {
    const Package p = oneVoxel(ct_hu, label);
    return Patient(p).at(Index3(0), flags);
}

// HZ-TEACH-19
TEST(Tissue, ThresholdsAreLowerBounds) {
    const Thresholds t = test::tissueDefaults().thresholds;
    EXPECT_EQ(sampleVoxel(int(t.t0_hu) - 1, kOutside).tissue, Tissue::air);
    EXPECT_EQ(sampleVoxel(int(t.t0_hu), kOutside).tissue, Tissue::skin);
    EXPECT_EQ(sampleVoxel(int(t.t1_hu) - 1, kOutside).tissue, Tissue::skin);
    EXPECT_EQ(sampleVoxel(int(t.t1_hu), kOutside).tissue, Tissue::soft);
    EXPECT_EQ(sampleVoxel(int(t.t2_sensitive_hu) - 1, kPastSkin).tissue, Tissue::soft);
    EXPECT_EQ(sampleVoxel(int(t.t2_sensitive_hu), kPastSkin).tissue, Tissue::bone);
    EXPECT_EQ(sampleVoxel(int(t.t2_sensitive_hu), kPastFascia).tissue, Tissue::soft);
    EXPECT_EQ(sampleVoxel(int(t.t2_specific_hu), kPastFascia).tissue, Tissue::bone);
}

TEST(Tissue, AirIsARiskPastTheSkin) {
    EXPECT_EQ(sampleVoxel(-1000, kOutside).role, Role::pass);
    EXPECT_EQ(sampleVoxel(-1000, kPastSkin).role, Role::risk);
}

TEST(Tissue, HasNoSecondSkinInside) {
    EXPECT_EQ(sampleVoxel(-400, kOutside).tissue, Tissue::skin);
    EXPECT_EQ(sampleVoxel(-400, kPastSkin).tissue, Tissue::soft);
    EXPECT_EQ(sampleVoxel(-400, kPastFascia).tissue, Tissue::soft);
}

// HZ-TEACH-19
TEST(Tissue, ALabelDecidesWhateverTheCtSays) {
    for (const Label& label : test::tissueLabels())
        for (const int ct_hu : {-1000, 0, 1500})
            for (const TrackFlags flags : {kOutside, kPastSkin, kPastFascia})
                EXPECT_EQ(sampleVoxel(ct_hu, flags, label.id),
                          (TissueSample{label.tissue, label.id, label.role}));
}

TEST(Tissue, AnIdWithoutAnEntryIsUnsegmented) {
    EXPECT_EQ(sampleVoxel(40, kOutside, 200), (TissueSample{Tissue::soft, 0, Role::pass}));
}

TEST(Tissue, BeyondTheGridIsAir) {
    const Package p = oneVoxel(40);
    EXPECT_EQ(Patient(p).at(Index3(1, 0, 0), kOutside), (TissueSample{Tissue::air, 0, Role::pass}));
    EXPECT_EQ(Patient(p).at(Index3(0, -1, 0), kPastSkin), (TissueSample{Tissue::air, 0, Role::risk}));
}

// HZ-TEACH-02
TEST(Tissue, ShippedTableIsTableOne) {
    const TissueTable& t = test::tissueDefaults().tissues;
    EXPECT_EQ(t[std::size_t(Tissue::skin)], (TissueRow{0.7, 0.7, 800.0, true, Role::pass}));
    EXPECT_EQ(t[std::size_t(Tissue::soft)], (TissueRow{0.7, 0.7, 1000.0, false, Role::pass}));
    EXPECT_EQ(t[std::size_t(Tissue::bone)], (TissueRow{INFINITY, 3.0, 2000.0, false, Role::risk}));
    EXPECT_EQ(t[std::size_t(Tissue::fascia)], (TissueRow{2.5, 1.0, 1000.0, true, Role::pass}));
    EXPECT_EQ(t[std::size_t(Tissue::liver)], (TissueRow{0.3, 0.9, 1200.0, false, Role::pass}));
    EXPECT_EQ(t[std::size_t(Tissue::vessel)], (TissueRow{1.05, 0.75, 1100.0, false, Role::risk}));
    EXPECT_EQ(t[std::size_t(Tissue::duct)], (TissueRow{1.2, 0.5, 1000.0, false, Role::target}));

    // Not in Table 1: harder than soft tissue, but a needle passes it.
    const TissueRow& cartilage = t[std::size_t(Tissue::cartilage)];
    const TissueRow &soft = t[std::size_t(Tissue::soft)], &bone = t[std::size_t(Tissue::bone)];
    EXPECT_GT(cartilage.cut_force_n, t[std::size_t(Tissue::fascia)].cut_force_n);
    EXPECT_TRUE(std::isfinite(cartilage.cut_force_n));
    EXPECT_NEAR(cartilage.friction_n, 0.5 * (soft.friction_n + bone.friction_n), 1e-12);
    EXPECT_GT(cartilage.stiffness_n_per_m, soft.stiffness_n_per_m);
    EXPECT_LT(1.5 * cartilage.stiffness_n_per_m, bone.stiffness_n_per_m) << "the steepest tangent is bone's";
    EXPECT_EQ(cartilage.role, Role::risk);

    // Every tissue has an elasticity with its source. Only the skeleton is rigid.
    for (int i = 0; i < kTissueCount; ++i) {
        const Elasticity& e = test::tissueDefaults().elasticity[std::size_t(i)];
        EXPECT_EQ(std::isinf(e.young_pa), isSkeleton(Tissue(i))) << tissueName(Tissue(i));
        EXPECT_GE(e.young_pa, 500.0) << tissueName(Tissue(i));
        EXPECT_GT(e.source.size(), 10u) << tissueName(Tissue(i));
    }
}

TEST(Slabs, BordersLieWhereTheyShould) {
    const test::OwnedPatient patient(
        test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.01}, {Tissue::liver, 0.02}}, 0.0005));
    EXPECT_EQ(patient.at(Vec3(-1e-6, 0, 0), kOutside).tissue, Tissue::air);
    EXPECT_EQ(patient.at(Vec3(1e-6, 0, 0), kOutside).tissue, Tissue::skin);
    EXPECT_EQ(patient.at(Vec3(0.002 + 1e-6, 0.019, -0.019), kOutside).tissue, Tissue::soft);
    EXPECT_EQ(patient.at(Vec3(0.012 - 1e-6, 0, 0), kOutside).tissue, Tissue::soft);
    EXPECT_EQ(patient.at(Vec3(0.012 + 1e-6, 0, 0), kOutside).tissue, Tissue::liver);
}

}  // namespace
}  // namespace stylet::patient
