#include "app/report/attempt_files.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace stylet::report;
using stylet::test::expectRefused;

const std::string kHead = "tick,time_s,depth_m,force_n,phase,tissue,breath_held\n";

void refuseCurve(const std::string& text, const std::string& field) {
    expectRefused([&] { parseCurve(text, "curve.csv"); }, "curve.csv", field);
}
void refuseSummary(const std::string& text, const std::string& field) {
    expectRefused([&] { parseSummary(text, "summary.json"); }, "summary.json", field);
}

TEST(AttemptFiles, CurveRowsAreParsed) {
    const std::vector<CourseRow> rows =
        parseCurve(kHead + "9,0.009,0.001,0.5,held,skin,1\n10,0.010,-2e-3,-0.25,pass,liver,0", "c");
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0].tissue, stylet::patient::Tissue::skin);
    EXPECT_TRUE(rows[0].breath_held && rows[0].in_body);
    EXPECT_DOUBLE_EQ(rows[1].t_s, 0.010);
    EXPECT_DOUBLE_EQ(rows[1].depth_m, -0.002);
    EXPECT_DOUBLE_EQ(rows[1].force_n, -0.25);
    EXPECT_TRUE(std::isnan(rows[1].clearance_m));
    EXPECT_TRUE(parseCurve(kHead, "c").empty());
}

TEST(AttemptFiles, BadCurvesAreRefused) {
    refuseCurve("tick,time_s\n", "line 1");
    refuseCurve(kHead + "9,x,0,0,held,skin,1\n", "line 2: time_s");
    refuseCurve(kHead + "9,0.009,nan,0,held,skin,1\n", "line 2: depth_m");
    refuseCurve(kHead + "9,0.009,0,inf,held,skin,1\n", "line 2: force_n");
    refuseCurve(kHead + "9,0.009,0,1e999,held,skin,1\n", "line 2: force_n");
    refuseCurve(kHead + "9,0.009,0,1,held,spleen,1\n", "line 2: tissue");
    refuseCurve(kHead + "9,0.009,0,1,held,skin,2\n", "line 2: breath_held");
    refuseCurve(kHead + "9,0.009,0,1,held,skin,1,5\n", "line 2: 8 fields, not 7");
    refuseCurve(kHead + "9,0.009,0,1,held,skin\n", "line 2: 6 fields, not 7");
    refuseCurve(kHead + "9,0.009,0,1,held,skin,1\n8,0.008,0,1,held,skin,1\n", "line 3: time_s");
    refuseCurve("", "line 1");
    refuseCurve(kHead + "\n", "line 2: 1 fields, not 7");
}

TEST(AttemptFiles, SummaryWithScoreIsParsed) {
    const Summary s = parseSummary(
        R"({"patient": "p", "seed": 3, "target_hit": true, "haptics": {"ticks": 12},
            "punctures": [{"tissue": "duct", "kind": "cut", "tick": 5, "force_before_n": 1.2}],
            "score": {"total": 71.5, "metrics": [{"id": "clearance", "name": "Clearance", "unit": "mm", "value": null, "points": 2, "most_points": 5}]}})",
        "s");
    EXPECT_EQ(s.seed, 3u);
    ASSERT_EQ(s.punctures.size(), 1u);
    EXPECT_DOUBLE_EQ(s.punctures[0].force_before_n, 1.2);
    ASSERT_TRUE(s.score);
    EXPECT_DOUBLE_EQ(s.score->total, 71.5);
    EXPECT_EQ(s.score->ticks, 12u);
    EXPECT_TRUE(s.score->target_hit);
    ASSERT_EQ(s.score->metrics.size(), 1u);
    EXPECT_TRUE(std::isnan(s.score->metrics[0].value));
    EXPECT_FALSE(parseSummary("{}", "s").score);
}

TEST(AttemptFiles, BadSummariesAreRefused) {
    refuseSummary("", "json");
    refuseSummary("{\"patient\": \"", "json");
    refuseSummary("[1]", "json");
    refuseSummary(std::string(100000, '['), "json");
    refuseSummary("{\"patient\": 1}", "patient");
    refuseSummary("{\"seed\": -1}", "seed");
    refuseSummary("{\"seed\": 1.5}", "seed");
    refuseSummary("{\"target_hit\": 1}", "target_hit");
    refuseSummary("{\"dose\": 1}", "dose");
    refuseSummary("{\"dose\": {\"fluoroscopy_s\": \"2\"}}", "dose.fluoroscopy_s");
    refuseSummary("{\"moments\": {}}", "moments");
    refuseSummary("{\"moments\": [1]}", "moments");
    refuseSummary("{\"score\": {\"metrics\": [{\"points\": []}]}}", "score.metrics[0].points");
}

TEST(AttemptFiles, AFolderWithoutAnAttemptIsRefused) {
    const stylet::test::TempFolder folder;
    expectRefused([&] { readFolder(folder.path()); }, folder.path().filename().string(), "folder");
}

}  // namespace
