// The page of one attempt: its figures, tables and names.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/report/attempt_page.h"
#include "app/report/glossary.h"
#include "app/report/slices.h"
#include "tests/app/report/attempts.h"
#include "tests/app/report/debrief.h"
#include "tests/support/file_text.h"
#include "tests/support/phantom.h"

namespace {

using namespace stylet::report;
using stylet::patient::Tissue;
using stylet::test::has;
using stylet::test::makeLoadedAttempt;
using stylet::test::makeOneStepAttempt;
using stylet::test::TempFolder;
using stylet::test::textFrom;

// HZ-TEACH-20
TEST(Debrief, AttemptPageShowsScoreEventsAndCourse) {
    const TempFolder folder;
    const LoadedAttempt a = makeLoadedAttempt(folder, 20000);
    AttemptContext context;
    context.cohort = stylet::test::makeTestCohort();
    const AttemptReport report = attemptReport(a, context);
    for (const char* text :
         {"71.0 of 100", "Force over depth", "Timeline", "Score", "Stills", "Facts", "duct, left eye",
          "close passes", "close pass", "1.4 mm from the portal vein", "Score table", "Glossary",
          "Registration error", "Device", "scripted", "image/jpeg", "Tools in hand: finger, probe, scalpel"})
        EXPECT_TRUE(has(report.html, text)) << text;
    LoadedAttempt named = a;
    named.record.needle = "chiba-22g", named.needle_title = "22 G Chiba needle";
    EXPECT_TRUE(has(attemptReport(named, {}).html, "chiba-22g (22 G Chiba needle)"));
    EXPECT_FALSE(has(report.html, "duct, right"));
    EXPECT_FALSE(has(report.html, "<script>alert"));
    ASSERT_EQ(report.metrics.rows.size(), 4u);  // three metrics and the total
    EXPECT_EQ(report.metrics.rows[0][0], "Tip to target");
    EXPECT_EQ(report.events.rows.size(), 8u);
    EXPECT_GT(report.course.rows.size(), 1000u);
    EXPECT_LE(report.course.rows.size(), 4001u);
    // Each row covers several ticks and preserves their peaks.
    const auto column = [&](const std::string& name) {
        return std::size_t(std::find(report.course.head.begin(), report.course.head.end(), name) -
                           report.course.head.begin());
    };
    double deepest_mm = 0.0, most_n = 0.0, peak_n = 0.0;
    std::size_t ticks = 0;
    for (const auto& row : report.course.rows) {
        ticks += std::stoul(row[column("ticks")]);
        if (row[column("force_max_n")].empty()) continue;
        deepest_mm = std::max(deepest_mm, std::stod(row[column("depth_max_mm")]));
        most_n = std::max(most_n, std::stod(row[column("force_max_n")]));
    }
    for (const CourseRow& row : a.course)
        peak_n = std::max(peak_n, row.force_n);
    EXPECT_EQ(ticks, a.course.size());
    EXPECT_NEAR(deepest_mm, 74.0, 0.001);
    EXPECT_NEAR(most_n, peak_n, 1e-4);
}

// HZ-TEACH-22
TEST(Debrief, OverruledPatientCheckIsStatedNearTheTop) {
    const TempFolder folder;
    LoadedAttempt a = makeLoadedAttempt(folder, 5000);
    EXPECT_FALSE(has(attemptReport(a, {}).html, "The check of this patient"));
    a.record.patient_check = "overruled: the check refused this patient: REFUSED  liver volume: 245 ml";
    const std::string html = attemptReport(a, {}).html;
    const std::size_t sentence = html.find(
        "<p>The check of this patient was overruled: the check refused this patient: REFUSED  liver volume: "
        "245 ml.</p>");
    ASSERT_NE(sentence, std::string::npos);
    EXPECT_LT(sentence, html.find("<h2"));
    a.record.patient_check = "not checked";
    EXPECT_TRUE(has(attemptReport(a, {}).html, "This patient was never checked"));
}

TEST(Debrief, ForceFigureSeparatesInsertionAndWithdrawal) {
    const TempFolder folder;
    const LoadedAttempt a = makeLoadedAttempt(folder, 20000);
    const DescribedFigure f = forceFigure(a, {{"expert", {{0.0, 0.1}, {80.0, 0.2}}}});
    ASSERT_EQ(f.figure.series.size(), 3u);
    EXPECT_TRUE(std::all_of(f.figure.series[0].points.begin(), f.figure.series[0].points.end(),
                            [](const FigurePoint& p) { return p.y > 0.0; }));
    EXPECT_TRUE(std::all_of(f.figure.series[1].points.begin() + 2, f.figure.series[1].points.end(),
                            [](const FigurePoint& p) { return p.y < 0.0; }));
    EXPECT_EQ(f.figure.marks.size(), 3u);
    std::vector<std::string> bands;
    for (const FigureBand& band : f.figure.bands)
        bands.push_back(band.text);
    EXPECT_EQ(bands, (std::vector<std::string>{"skin", "soft", "fascia", "liver", "duct"}));
    EXPECT_NEAR(f.figure.bands[2].from, 33.0, 0.1);
    // The table contains the same curves. Its row at 40 mm has insertion, withdrawal and the expert's
    // insertion.
    const auto row =
        std::find_if(f.data.rows.begin(), f.data.rows.end(), [](const auto& r) { return r[0] == "40"; });
    ASSERT_NE(row, f.data.rows.end());
    const double there = 0.7 + 0.2 * std::sin(900.0 * 0.040);
    EXPECT_NEAR(std::stod((*row)[1]), there, 0.03);
    EXPECT_NEAR(std::stod((*row)[2]), -0.6 * there, 0.03);
    EXPECT_EQ((*row)[3], "0.15");
}

TEST(Debrief, EarlierInsertionsAreASeparateSeries) {
    const TempFolder folder;
    LoadedAttempt a = makeLoadedAttempt(folder, 20000);
    // A first insertion to 20 mm, well before the main one.
    for (std::size_t i = 1000; i < 3000; ++i) {
        a.course[i].in_body = true;
        a.course[i].depth_m = 0.02 - 0.02 * std::fabs(double(i) - 2000.0) / 1000.0;
        a.course[i].force_n = 5.0;
    }
    const DescribedFigure f = forceFigure(a, {});
    ASSERT_EQ(f.figure.series.size(), 3u);
    EXPECT_LT(std::max_element(f.figure.series[0].points.begin(), f.figure.series[0].points.end(),
                               [](const FigurePoint& p, const FigurePoint& q) { return p.y < q.y; })
                  ->y,
              1.0);
    EXPECT_EQ(f.figure.series[2].name, "earlier tries");
    EXPECT_EQ(f.figure.series[2].points[0].y, 5.0);
    EXPECT_TRUE(has(f.caption, "in the body before"));
    for (auto& puncture : a.stored.result->punctures)
        puncture.tick = 1500;
    EXPECT_TRUE(forceFigure(a, {}).figure.marks.empty());
}

TEST(Debrief, ReferenceCurveIsExactAndStartsAtTheSkin) {
    const stylet::patient::Package package = stylet::test::makeSlabs(
        {{Tissue::skin, 0.002}, {Tissue::soft, 0.010}, {Tissue::fascia, 0.002}, {Tissue::liver, 0.030}},
        0.0005);
    const stylet::patient::Patient patient(package);
    stylet::patient::PlannedPath path;
    path.entry_reference_m = {0.00025, 0.0, 0.0};  // centre of the first skin voxel
    path.target_reference_m = {0.030, 0.0, 0.0};
    const ReferenceCurve curve = exactCurve(patient, path, {});
    ASSERT_FALSE(curve.points.empty());
    EXPECT_NEAR(curve.points.front().x, 0.0, 1e-6);
    EXPECT_NEAR(curve.points.back().x, 30.0, 1e-6);
    const auto peak = std::max_element(curve.points.begin(), curve.points.end(),
                                       [](const FigurePoint& a, const FigurePoint& b) { return a.y < b.y; });
    // The fascia is punctured at its threshold force, behind its border at 12 mm.
    EXPECT_NEAR(peak->y, patient.row(Tissue::fascia).cut_force_n, 1e-6);
    EXPECT_GT(peak->x, 12.0);
    EXPECT_LT(peak->x, 14.5);
    // A thinner needle meets less friction: the force at the target is that of the liver, scaled.
    stylet::haptics::NeedleSettings thin;
    thin.friction_scale = 0.48;
    EXPECT_NEAR(curve.points.back().y, patient.row(Tissue::liver).friction_n, 1e-9);
    EXPECT_NEAR(exactCurve(patient, path, thin).points.back().y, 0.48 * patient.row(Tissue::liver).friction_n,
                1e-9);
    path.target_reference_m = path.entry_reference_m;
    EXPECT_TRUE(exactCurve(patient, path, {}).points.empty());
}

TEST(Debrief, SlicesShowTheTipsTrack) {
    const stylet::patient::Package package =
        stylet::test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::liver, 0.030}}, 0.001);
    const stylet::patient::Patient patient(package);
    NeedlePicture needle;
    needle.tip_m = {0.02, 0.0, 0.0}, needle.axis = {1.0, 0.0, 0.0}, needle.depth_m = 0.02;
    const SliceSheet without = sliceSheet(patient, needle);
    needle.trail_m = {{0.0, 0.005, 0.0}, {0.02, 0.0, 0.0}};
    const SliceSheet with = sliceSheet(patient, needle);
    EXPECT_EQ(without.width, with.width);
    EXPECT_NE(without.png, with.png);
    ASSERT_GT(with.png.size(), 8u);
    EXPECT_EQ(with.png[1], 'P');
}

TEST(Debrief, MetricTableShowsCohortPercentiles) {
    const auto cohort = stylet::test::makeTestCohort();
    const Table table = metricTable(*cohort[0].result, cohort);
    EXPECT_EQ(table.rows.back()[0], "Total");
    EXPECT_EQ(table.rows.back()[7], "2");  // Lowest of 30. A tie counts half: 0.5 / 30 is 2 %.
    const Table alone = metricTable(*cohort[0].result, {cohort[0]});
    EXPECT_EQ(alone.rows.back()[7], "–");
}

// Points and weight have the same digits, so that no metric seems to earn more than its weight.
TEST(Debrief, NoMetricSeemsToEarnMoreThanItsWeight) {
    stylet::records::AttemptResult result;
    result.metrics.push_back({"targeting", "Targeting", "mm", 1.0, 7.547, 7.547});
    const Table table = metricTable(result, {});
    EXPECT_EQ(table.rows.front()[3], table.rows.front()[4]);
}

// One number has one name: the metric counts grades and hits, the events count passes without a hit.
TEST(Debrief, NumbersWithDifferentMeaningHaveDifferentNames) {
    const TempFolder folder;
    const std::string html = attemptReport(makeOneStepAttempt(folder), {}).html;
    EXPECT_TRUE(has(html, "<b>1</b><span>close passes that touched nothing</span>"));
    EXPECT_TRUE(has(html, ">Near misses, graded, with hits</th>"));
    EXPECT_FALSE(has(html, "near misses</span>"));
    EXPECT_TRUE(has(html, "<b>14.00 N</b><span>largest axial force</span>")) << "as the metric";
    EXPECT_TRUE(has(html, "<b>0</b><span>no-go areas touched</span>")) << "as the metric";
}

// The headline of an attempt that struck something says what.
TEST(Debrief, TheHeadlineStatesWhatWasStruck) {
    const TempFolder folder;
    LoadedAttempt a = makeOneStepAttempt(folder);
    for (stylet::records::MetricRow& row : a.stored.result->metrics)
        row.value = row.id == "no_go_touches" ? 18.0
                    : row.id == "vessel_hits" ? 12.0
                    : row.id == "bone_hits"   ? 6.0
                                              : row.value;
    const std::string html = attemptReport(a, {}).html;
    EXPECT_TRUE(has(html, "<b>18</b><span>no-go areas touched: blood vessel 12, bone 6</span>"));
    EXPECT_FALSE(has(html, "nothing struck"));
}

// The page explains its terms in the words of the guide, and nowhere else.
TEST(Debrief, TheGlossaryIsTheGuides) {
    const std::string guide =
        stylet::test::readText(std::filesystem::path(std::getenv("STYLET_ASSETS")).parent_path() /
                               "packaging" / "guide" / "glossary.md");
    ASSERT_GT(glossary().size(), 10u);
    std::size_t rows = 0;
    for (std::size_t at = 0; (at = guide.find("\n| ", at)) != guide.npos; ++at)
        ++rows;
    EXPECT_EQ(glossary().size(), rows - 1) << "all rows but the head";
    const TempFolder folder;
    const std::string html = attemptReport(makeOneStepAttempt(folder), {}).html;
    const std::string section = textFrom(html, "Glossary</h2>", "</dl>");
    for (const Fact& term : glossary()) {
        EXPECT_TRUE(has(guide, "| " + term.name + " | " + term.value + " |")) << term.name;
        if (has(section, "<dt>" + escaped(term.name) + "</dt>")) {
            EXPECT_TRUE(has(section, escaped(term.value))) << term.name;
        }
    }
    for (const char* used : {"axial force", "close pass", "score table", "no-go area"})
        EXPECT_TRUE(has(section, std::string("<dt>") + used + "</dt>")) << used;
    EXPECT_FALSE(has(section, "<dt>CUSUM</dt>")) << "not on this page";
}

}  // namespace
