#include "app/report/curve.h"

#include <gtest/gtest.h>

#include "patient/patient.h"
#include "tests/support/temp_folder.h"

namespace stylet::report {
namespace {

using haptics::Phase;
using patient::Tissue;

std::vector<ForceSample> someCurve() {
    return {{7801, 0.0, 0.0, Phase::tenting, Tissue::air, true},
            {7802, 0.0004, 0.25, Phase::tenting, Tissue::air, true},
            {7803, 0.0009, 0.7, Phase::pass, Tissue::skin, true},
            {7804, 0.0005, -0.125, Phase::pass, Tissue::skin, false}};
}

std::size_t sizeOf(const std::filesystem::path& file) {
    return std::filesystem::exists(file) ? std::size_t(std::filesystem::file_size(file)) : 0;
}

TEST(Curve, MissingFolderIsRefused) {
    EXPECT_THROW(drawCurve(someCurve(), {}, "title", "/nonexistent/curve.png"), DataError);
}

TEST(Curve, DrawsCurveWithMarksAndEmptyCurve) {
    const test::TempFolder folder;
    drawCurve(someCurve(), {}, "title", folder / "plain.png");
    drawCurve(someCurve(), {{"skin 0.70 N", 0.0009, 0.7}}, "title", folder / "marked.png");
    drawCurve({}, {}, "title", folder / "empty.png");
    EXPECT_GT(sizeOf(folder / "empty.png"), 1000u);
    EXPECT_GT(sizeOf(folder / "plain.png"), sizeOf(folder / "empty.png"));
    EXPECT_GT(sizeOf(folder / "marked.png"), sizeOf(folder / "plain.png"));
}

}  // namespace
}  // namespace stylet::report
