#include "patient/package/tissue_map.h"

#include <gtest/gtest.h>

#include "tests/support/phantom.h"
#include "tests/support/refused.h"

namespace stylet::patient {
namespace {

// A package with every label of the phantom, labels without a table entry, every HU class, and CT values
// equal to the thresholds.
Package everyKind() {
    Package package = test::makeSlabs({{Tissue::soft, 0.004}}, 0.001);
    package.thresholds = {-500.0, -200.0, 200.0, 300.0};
    package.label_table[0].abdominal = true;
    constexpr std::int16_t kHu[] = {-1000, -501, -500, -201, -200, 0, 199, 200, 250, 299, 300, 1000};
    for (std::size_t i = 0; i < package.ct.voxels.size(); ++i) {
        package.ct.voxels[i] = kHu[i % std::size(kHu)];
        package.labels.voxels[i] = std::uint8_t(i / std::size(kHu) % 10);  // 0, 1 to 7, two unknown ids
    }
    return package;
}

// HZ-TEACH-19
TEST(TissueMap, MatchesAlgorithm1AtEveryVoxel) {
    const test::OwnedPatient patient(everyKind());
    const TissueMap map(patient);
    for (const TrackFlags flags : kAllTrackFlags) {
        forEachVoxel(Index3(-1), map.grid().dims, [&](const Index3& i) {
            const TissueSample expected = patient.at(i, flags);
            ASSERT_EQ(map.sample(map.code(i), flags), expected);
            const TrackFlags after = map.flagsAfterEntering(map.code(i), flags);
            const TrackFlags expected_after = patient.flagsAfterEntering(expected, flags);
            ASSERT_EQ(after.past_skin, expected_after.past_skin);
            ASSERT_EQ(after.past_fascia, expected_after.past_fascia);
        });
    }
}

TEST(TissueMap, RejectsMoreThan256Codes) {
    Package package = everyKind();
    package.label_table.clear();
    for (int id = 1; id < 256; ++id)
        package.label_table.emplace_back().id = std::uint8_t(id);
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i)
        package.labels.voxels[i] = std::uint8_t(i % 256);
    // 255 labels, five classes and the air beyond the grid.
    test::expectRefused([&] { TissueMap{Patient(package)}; }, package.name, "labels");
}

}  // namespace
}  // namespace stylet::patient
