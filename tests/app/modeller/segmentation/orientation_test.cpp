#include "app/modeller/segmentation/orientation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/modeller/image/import_error.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"
#include "tests/support/refused.h"

namespace stylet::modeller {
namespace {

using test::box;

// 100 x 100 x 300 mm.
const Grid kGrid{Index3(10, 10, 30), Vec3(0.010), Vec3(0.0)};
const Mask kBody(kGrid, 1), kNothing(kGrid);

// A slab of the body, from one slice to another.
Mask slices(int first, int last) {
    return box(kGrid, {1, 1, first}, {8, 8, last});
}
// The same, from back to front.
Mask layers(int first, int last) {
    return box(kGrid, {1, first, 1}, {8, last, 28});
}

TEST(Orientation, LungsBelowTheMiddleMeanUpsideDown) {
    EXPECT_EQ(test::errorText<ImportError>([] { checkUpright(kBody, slices(20, 29), "ct"); }), "");
    EXPECT_THAT(test::errorText<ImportError>([] { checkUpright(kBody, slices(0, 9), "a/ct.nii.gz"); }),
                testing::StartsWith("a/ct.nii.gz: axes: the scan is upside down"));
    // The middle is at 145 mm.
    EXPECT_EQ(test::errorText<ImportError>([] { checkUpright(kBody, slices(10, 13), "ct"); }), "")
        << "25 mm below";
    EXPECT_NE(test::errorText<ImportError>([] { checkUpright(kBody, slices(9, 12), "ct"); }), "")
        << "35 mm below";
    EXPECT_EQ(test::errorText<ImportError>([] { checkUpright(kBody, kNothing, "ct"); }), "");
}

TEST(Orientation, BonesInFrontMeanFrontAndBackExchanged) {
    EXPECT_EQ(test::errorText<ImportError>([] { checkFrontAndBack(kBody, layers(1, 3), "ct"); }), "");
    EXPECT_THAT(test::errorText<ImportError>([] { checkFrontAndBack(kBody, layers(6, 8), "a/ct.nii.gz"); }),
                testing::StartsWith("a/ct.nii.gz: axes: front and back of the scan are exchanged"));
    EXPECT_EQ(test::errorText<ImportError>([] { checkFrontAndBack(kBody, kNothing, "ct"); }), "");
}

}  // namespace
}  // namespace stylet::modeller
