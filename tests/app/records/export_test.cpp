#include "app/records/export.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/records/some_result.h"
#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using haptics::Phase;
using haptics::Tissue;

TEST(Export, CurveContainsEveryTick) {
    const test::TempFolder folder;
    exportCurve({{7801, 0.0, 0.0, Phase::tenting, Tissue::air, true},
                 {7802, 0.0004, 0.25, Phase::tenting, Tissue::air, true},
                 {7803, 0.0009, 0.7, Phase::pass, Tissue::skin, true},
                 {7804, 0.0005, -0.125, Phase::pass, Tissue::skin, false}},
                0.001, folder / "curve.csv");
    EXPECT_EQ(test::readText(folder / "curve.csv"),
              "tick,time_s,depth_m,force_n,phase,tissue,breath_held\n"
              "7801,7.801,0.0000000,0.000000,held,air,1\n"
              "7802,7.802,0.0004000,0.250000,held,air,1\n"
              "7803,7.803,0.0009000,0.700000,pass,skin,1\n"
              "7804,7.804,0.0005000,-0.125000,pass,skin,0\n");
    EXPECT_THROW(exportCurve({}, 0.001, "/nonexistent/curve.csv"), DataError);
}

TEST(Export, SummaryHasTheRecordsFactsAndResultAndThePerformance) {
    const test::TempFolder folder;
    RecordInfo info;
    info.patient_name = "someone", info.scenario = "demo", info.clock = "virtual", info.seed = 7;
    info.path.length_m = 0.08;
    info.end = RecordEnd{12345, 0xabcull};
    info.result = test::someResult();
    exportSummary(info, {{"frames", 60}}, folder / "summary.json");
    auto summary = nlohmann::json::parse(test::readText(folder / "summary.json"));
    EXPECT_EQ(summary.at("patient"), "someone");
    EXPECT_EQ(summary.at("seed"), 7);
    EXPECT_EQ(summary.at("path").at("length_m"), 0.08);
    EXPECT_EQ(summary.at("frames"), 60);
    EXPECT_EQ(summary.at("state_hash"), "0000000000000abc");
    const nlohmann::json result = resultJson(*info.result);
    for (const auto& [key, value] : result.items())
        EXPECT_EQ(summary.at(key), value) << key;
    EXPECT_EQ(summary.at("score").at("metrics").at(1).at("value"), nullptr) << "not achieved";
    info.result->force_truth.reset();
    exportSummary(info, nlohmann::ordered_json::object(), folder / "summary.json");
    summary = nlohmann::json::parse(test::readText(folder / "summary.json"));
    EXPECT_EQ(summary.at("force_truth"), "no full segmentation of this patient");
}

}  // namespace
}  // namespace stylet::records
