#include "haptics/tools/gauge.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "base/whole_file.h"
#include "haptics/tools/needle.h"
#include "tests/app/trainer/assets.h"
#include "tests/support/refused.h"

namespace stylet::haptics {
namespace {

std::filesystem::path gaugeFile() {
    return test::assets() / "instruments" / "needles.toml";
}

void refuses(const std::string& toml, const std::string& field) {
    test::expectRefused([&] { parseGauges("needles.toml", toml); }, "needles.toml", field);
}

TEST(Gauges, TheDefaultIsTheNeedleOfTheForceModel) {
    EXPECT_EQ(loadGauge(gaugeFile(), kDefaultGauge).outer_m, NeedleSettings{}.cut_reach_m);
}

// The table of the guide has one line per gauge.
TEST(Gauges, TheDocumentedTableIsTheFile) {
    std::ifstream page(test::assets().parent_path() / "packaging" / "guide" / "model.md");
    ASSERT_TRUE(page);
    std::string rows, expected;
    bool table = false;
    for (std::string line; std::getline(page, line);) {
        table = line.starts_with("| gauge |") || (table && line.starts_with("|"));
        if (table && !line.starts_with("| gauge |") && !line.starts_with("|---")) rows += line + "\n";
    }
    for (const NeedleGauge& needle : parseGauges("needles.toml", readWholeFile(gaugeFile(), 1 << 16))) {
        std::ostringstream row;
        row << "| " << needle.gauge << " G | " << 1e3 * needle.outer_m << " |\n";
        expected += row.str();
    }
    EXPECT_EQ(rows, expected);
}

TEST(Gauges, WrongFilesAreRefused) {
    const std::string good = "[[needle]]\ngauge = 22\nouter_mm = 0.7\n";
    EXPECT_EQ(parseGauges("needles.toml", good).size(), 1u);
    refuses("", "needle");
    refuses("[[needle]]\n", "needle[0].gauge");
    refuses("[[needle]]\ngauge = 22\n", "needle[0].outer_mm");
    refuses("[[needle]]\ngauge = 22\nouter_mm = nan\n", "needle[0].outer_mm");
    refuses("[[needle]]\ngauge = 2200000000000\nouter_mm = 1\n", "needle[0].gauge");
    refuses(good + "length_mm = 1\n", "needle[0].length_mm");
    refuses(good + good, "needle[1].gauge: twice");
    refuses("[[needle", "line 1");
    test::expectRefused([] { loadGauge(gaugeFile(), 33); }, "needles.toml", "gauge 33");
}

}  // namespace
}  // namespace stylet::haptics
