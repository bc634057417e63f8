#include "patient/package/tissue_map.h"

#include <gtest/gtest.h>

#include "tests/support/phantom.h"

namespace stylet::patient {
namespace {

// Every label of the phantom, labels without a table entry, every HU class and the thresholds themselves.
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
TEST(TissueMap, SaysOfEveryVoxelWhatAlgorithm1SaysOfIt) {
    const Package package = everyKind();
    const Patient patient(package);
    const TissueMap map(patient);
    for (const TrackFlags flags : {TrackFlags{false, false}, {true, false}, {false, true}, {true, true}}) {
        Index3 i;
        for (i.z = -1; i.z <= map.grid().dims.z; ++i.z) {
            for (i.y = -1; i.y <= map.grid().dims.y; ++i.y) {
                for (i.x = -1; i.x <= map.grid().dims.x; ++i.x) {
                    const TissueSample expected = patient.at(i, flags);
                    ASSERT_EQ(map.sample(map.code(i), flags), expected);
                    const TrackFlags after = map.flagsAfterEntering(map.code(i), flags);
                    const TrackFlags expected_after = patient.flagsAfterEntering(expected, flags);
                    ASSERT_EQ(after.past_skin, expected_after.past_skin);
                    ASSERT_EQ(after.past_fascia, expected_after.past_fascia);
                }
            }
        }
    }
}

TEST(TissueMap, RefusesMoreKindsThanAByteTellsApart) {
    Package package = everyKind();
    package.label_table.clear();
    for (int id = 1; id < 256; ++id)
        package.label_table.emplace_back().id = std::uint8_t(id);
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i)
        package.labels.voxels[i] = std::uint8_t(i % 256);
    try {
        const TissueMap map{Patient(package)};
        FAIL() << "255 labels, five classes and the air beyond the grid";
    } catch (const DataError& e) {
        EXPECT_NE(std::string(e.what()).find("labels"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace stylet::patient
