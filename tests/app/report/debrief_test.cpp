#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <map>

#include "app/records/export.h"
#include "app/report/advice.h"
#include "app/report/attempt_page.h"
#include "app/report/commands.h"
#include "app/report/glossary.h"
#include "app/report/group_pages.h"
#include "app/report/slices.h"
#include "app/report/verdict.h"
#include "tests/app/report/attempt_folder.h"
#include "tests/support/file_text.h"
#include "tests/support/phantom.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace {

using namespace stylet::report;
using stylet::patient::Tissue;
using stylet::test::TempFolder;

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

LoadedAttempt makeLoadedAttempt(const TempFolder& folder, std::uint64_t ticks) {
    stylet::test::writeAttemptFolder(folder.path(), ticks);
    return loadAttempt(folder.path());
}

TEST(Debrief, ReadsSamplesAndReportsUnreadableFiles) {
    const TempFolder folder;
    LoadedAttempt a = makeLoadedAttempt(folder, 5000);
    ASSERT_EQ(a.course.size(), 5000u);
    EXPECT_TRUE(a.warnings.empty());
    EXPECT_EQ(a.course[100].tool, stylet::haptics::Tool::finger);
    EXPECT_FALSE(a.course[100].in_body);
    EXPECT_NEAR(a.course[3499].depth_m, 0.074, 1e-6);
    EXPECT_NEAR(a.course[3499].sent_n, 0.4 * std::fabs(a.course[3499].force_n), 1e-6);
    EXPECT_EQ(deepestRow(a.course), 3499u);
    std::filesystem::resize_file(folder / "record/samples.bin",
                                 std::filesystem::file_size(folder / "record/samples.bin") - 10);
    a = loadAttempt(folder.path());
    EXPECT_LT(a.course.size(), 5000u);
    EXPECT_GE(a.course.size(), 4000u);
    ASSERT_EQ(a.warnings.size(), 1u);
    std::ofstream(folder / "record/samples.bin") << "nonsense";
    std::ofstream(folder / "duct_left.png") << "no picture";
    a = loadAttempt(folder.path());
    EXPECT_TRUE(a.course.empty());
    const std::string html = attemptReport(a, {}).html;
    EXPECT_TRUE(has(html, "What could not be read"));
    EXPECT_TRUE(has(html, "duct_left.png: header: is not that of a PNG"));
    EXPECT_TRUE(has(html, "The needle did not enter the body."));
}

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

// HZ-TEACH-01
TEST(Debrief, ExamIsPassedByPointsGoalAndNoCriticalError) {
    stylet::records::StoredAttempt attempt;
    EXPECT_FALSE(passed(attempt)) << "no result";
    attempt.result.emplace();
    attempt.result->target_hit = true;
    attempt.result->total = 100.0;
    attempt.result->steps = {"advance to the duct", {"find the duct"}, 6, 0};
    EXPECT_FALSE(passed(attempt)) << "the duct was cut, but the step does not count";
    attempt.result->steps.done = {"advance to the duct"};
    EXPECT_TRUE(passed(attempt));
    attempt.result->steps.goal = "place the drain";
    EXPECT_FALSE(passed(attempt)) << "a puncture is not a drainage";
    attempt.result->steps.done.emplace_back("place the drain");
    EXPECT_TRUE(passed(attempt)) << "as an attempt of an older score table";
    attempt.result->total = stylet::training::kPassMark - 0.1;
    EXPECT_FALSE(passed(attempt));
    attempt.result->total = 100.0;
    attempt.events.push_back({200, "critical", "the lung was punctured"});
    EXPECT_FALSE(passed(attempt)) << "whatever the sum";
    EXPECT_EQ(criticalErrors(attempt), std::vector<std::string>{"the lung was punctured"});
}

// HZ-TEACH-25
TEST(Debrief, ExamIsFailedByAMissingPartWhichIsTold) {
    using namespace stylet::training;
    const TempFolder folder;
    stylet::records::StoredAttempt attempt = stylet::test::makeTestAttempt("t1", "trainee-A", 100.0, true);
    attempt.info.difficulty = "exam";
    attempt.result->score_version = std::uint64_t(kScoreVersion);
    attempt.result->steps = {"place the drain", {}, kStepCount, 0};
    for (int step = 0; step < kStepCount; ++step)
        attempt.result->steps.done.emplace_back(stepName(Step(step)));
    EXPECT_TRUE(passed(attempt));
    EXPECT_TRUE(missingParts(*attempt.result).empty());
    std::erase(attempt.result->steps.done, stepName(Step::anaesthetise));
    EXPECT_FALSE(passed(attempt));
    EXPECT_EQ(missingParts(*attempt.result), std::vector<std::string>{"local anaesthesia"});
    attempt.result->score_version = std::uint64_t(kExamPartsVersion) - 1;
    EXPECT_TRUE(passed(attempt)) << "by the rule of its time";
    attempt.result->score_version = std::uint64_t(kScoreVersion);
    stylet::test::writeAttemptFolder(folder.path(), 20000, attempt);
    const std::string html = attemptReport(loadAttempt(folder.path()), {}).html;
    EXPECT_TRUE(has(html, "Missing for an exam"));
    EXPECT_TRUE(has(html, "local anaesthesia"));
}

// An attempt that did one of six steps and touched nothing, with today's metric table.
stylet::records::AttemptResult oneStepResult() {
    using namespace stylet::training;
    MetricValues values;
    for (std::size_t i = 0; i < kMetricCount; ++i)
        values[i] = metricTable()[i].best;
    values[std::size_t(MetricId::procedure)] = 10.0;
    values[std::size_t(MetricId::skinContacts)] = 12.0;
    values[std::size_t(MetricId::peakForce)] = 14.0;
    values[std::size_t(MetricId::nearMisses)] = 3.0;
    const Score score = computeScore(values, 1u << unsigned(Step::findGap));
    stylet::records::AttemptResult result;
    result.total = score.total, result.ticks = 20000;
    result.score_version = std::uint64_t(kScoreVersion);
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        const Metric& m = metricTable()[i];
        if (!isMetricOf(score.course, m)) continue;
        result.metrics.push_back({std::string(m.id), std::string(m.name), std::string(m.unit), values[i],
                                  score.points[i], score.max_points[i]});
    }
    result.steps = {"advance to the duct", {"find the space between the ribs"}, 6, 0};
    return result;
}

// A drainage recorded before there were cases, and scored again: its review was not asked for. HZ-TEACH-01
TEST(Debrief, AnAttemptWithoutACaseIsScoredWithoutItsReview) {
    using namespace stylet::training;
    stylet::records::AttemptResult result;
    result.score_version = std::uint64_t(kScoreVersion);
    result.steps = {std::string(stepName(goalOf(Course::drainage))), {}, kStepCount - 1, 0};
    for (int step = 1; step < kStepCount; ++step)
        result.steps.done.emplace_back(stepName(Step(step)));
    for (const Metric& m : metricTable())
        if (m.id != "case_review")
            result.metrics.push_back(
                {std::string(m.id), std::string(m.name), std::string(m.unit), m.best, 1.0, 1.0});
    const auto score = findScore(result);
    ASSERT_TRUE(score);
    EXPECT_FALSE(score->has_case);
    EXPECT_NEAR(score->total, 100.0, 1e-9);
    EXPECT_EQ(score->max_points[std::size_t(MetricId::caseReview)], 0.0);
    result.metrics.pop_back();
    EXPECT_FALSE(findScore(result)) << "another metric is missing";
}

LoadedAttempt makeOneStepAttempt(const TempFolder& folder, bool aborted = false) {
    stylet::records::StoredAttempt attempt = stylet::test::makeTestAttempt("t1", "trainee-A", 0.0, false);
    attempt.result = oneStepResult();
    attempt.result->aborted = aborted;
    stylet::test::writeAttemptFolder(folder.path(), 20000, attempt);
    return loadAttempt(folder.path());
}

std::string textFrom(const std::string& html, const std::string& begin, const std::string& end) {
    const std::size_t from = html.find(begin), to = html.find(end, from);
    return from == html.npos ? "" : html.substr(from, to - from);
}

TEST(Debrief, AdviceComesFromTheLargestLossesWithTheirMoments) {
    const TempFolder folder;
    const LoadedAttempt a = makeOneStepAttempt(folder);
    const std::vector<Advice> all = makeAdvice(a);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_TRUE(has(all[0].text, "part of the procedure that was done: 1 of 6 steps")) << all[0].text;
    EXPECT_NEAR(all[0].t_s, 9.0, 1e-9) << "the last step";
    // Twelve contacts cost more than 14 N, and 14 N as much as three near misses. The only contact is one of
    // those that are free, so the value is that of the end.
    EXPECT_TRUE(has(all[1].text, "Skin contacts, 12 (full points up to 5)")) << all[1].text;
    EXPECT_NEAR(all[1].t_s, a.course.back().t_s, 1e-9);
    EXPECT_TRUE(has(all[2].text, "3")) << all[2].text;
    EXPECT_TRUE(a.course[all[2].row].in_body);
    for (const Advice& advice : all) {
        EXPECT_NEAR(a.course[advice.row].t_s, advice.t_s, 1e-3);
        EXPECT_FALSE(has(advice.text, "no-go")) << advice.text;
    }

    const std::string html = attemptReport(a, {}).html;
    // Score, then advice, then everything else.
    const std::size_t score = html.find("of 100</b>"), advice = html.find("class=\"advice\""),
                      force = html.find("Force over depth</h2>");
    EXPECT_LT(score, html.find("<nav"));
    EXPECT_LT(score, advice);
    EXPECT_LT(advice, force);
    for (const char* number : {"1", "2", "3"}) {
        EXPECT_TRUE(has(html, std::string("href=\"#moment-") + number + "\"")) << number;
        EXPECT_TRUE(has(html, std::string("<tr id=\"moment-") + number + "\">")) << number;
        EXPECT_TRUE(has(html, std::string("advice ") + number)) << number << ": in a figure";
    }
    EXPECT_TRUE(has(html, "Scored with version"));
    // What lost nothing by its value is not blamed for it.
    EXPECT_TRUE(has(textFrom(html, "Time in no-go areas</th>", "</tr>"), ">steps</td>"));
    EXPECT_TRUE(has(textFrom(html, ">Skin contacts</th>", "</tr>"), ">value, steps</td>"));
}

// Which answer was wrong, and why, with the source's limit.
TEST(Debrief, ListsTheAnswersAboutTheCase) {
    const TempFolder folder;
    LoadedAttempt a = makeOneStepAttempt(folder);
    EXPECT_FALSE(has(attemptReport(a, {}).html, "Review of the case")) << "there was no case";
    a.stored.events.push_back(
        {900, "answer", "Must the clotting be corrected? No: wrong, the INR of 2.4 is above 1.8 (SIR 2019)"});
    a.stored.events.push_back({950, "answer", "not of this form"});
    const std::string html = attemptReport(a, {}).html;
    const std::string table = textFrom(html, "Review of the case", "</table>");
    EXPECT_TRUE(has(table, "Must the clotting be corrected?</th>")) << table;
    EXPECT_TRUE(has(table, ">No</td>"));
    EXPECT_TRUE(has(table, ">wrong, the INR of 2.4 is above 1.8 (SIR 2019)</td>"));
    EXPECT_TRUE(has(table, "not of this form"));
}

TEST(Debrief, WhoReachedNothingGetsNoAdvice) {
    const TempFolder folder;
    LoadedAttempt a = makeOneStepAttempt(folder, true);
    a.stored.result->steps.done.clear();
    a.course.resize(3000);  // before the needle enters
    EXPECT_TRUE(makeAdvice(a).empty());
    EXPECT_TRUE(has(attemptReport(a, {}).html, "so there is no advice"));
    a.stored.result.reset();
    EXPECT_TRUE(makeAdvice(a).empty());
    EXPECT_TRUE(has(attemptReport(a, {}).html, "no score and no advice"));
}

// With an older table the reasons are unknown, and the page says so.
TEST(Debrief, AnotherScoreTableIsNamed) {
    const TempFolder folder;
    LoadedAttempt a = makeOneStepAttempt(folder);
    a.stored.result->score_version = std::uint64_t(stylet::training::kScoreVersion) + 41;
    EXPECT_FALSE(findScore(*a.result()));
    EXPECT_EQ(makeAdvice(a).size(), 3u);
    const std::string html = attemptReport(a, {}).html;
    EXPECT_TRUE(has(html, "Scored with version " + std::to_string(a.result()->score_version)));
    EXPECT_TRUE(has(html, "stylet replay ATTEMPT --fast"));
    a.stored.result->score_version = std::uint64_t(stylet::training::kScoreVersion);
    a.stored.result->metrics.pop_back();
    EXPECT_FALSE(findScore(*a.result())) << "a metric is missing";
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

// A part of the timeline that contains only the tool in hand explains no advice.
TEST(Debrief, AnAdviceWithoutAnythingToDrawHasNoFigure) {
    const TempFolder folder;
    LoadedAttempt a = makeOneStepAttempt(folder);
    const Advice advice{"Do the missing steps too.", 8.5, 8499};
    ASSERT_FALSE(a.course[advice.row].in_body);
    ASSERT_TRUE(momentFigure(a, advice, 1)) << "with the step";
    a.stored.events = {{8800, "tool", "probe"}};
    for (CourseRow& row : a.course)
        row.breath_held = row.in_body = false, row.faults = 0;
    EXPECT_FALSE(momentFigure(a, advice, 1));
    a.stored.events.push_back({8900, "comment", "look here"});
    EXPECT_TRUE(momentFigure(a, advice, 1));
}

TEST(Debrief, AbortedAttemptsAreMarkedAndEnterNoStatistics) {
    const TempFolder folder;
    const auto cohort = stylet::test::makeTestCohort();
    const LoadedAttempt a = makeOneStepAttempt(folder, true);
    AttemptContext context;
    context.cohort = cohort;
    const AttemptReport page = attemptReport(a, context);
    EXPECT_TRUE(has(page.html, "State: aborted"));
    EXPECT_TRUE(has(page.html, "This attempt was aborted"));
    EXPECT_EQ(page.metrics.rows.back()[7], "–") << "compared with nobody";

    // Aborted attempts change no number of the others.
    std::vector<stylet::records::StoredAttempt> more = cohort;
    for (int i = 0; i < 9; ++i) {
        more.push_back(stylet::test::makeTestAttempt("gone" + std::to_string(i), "trainee-B", 0.0, false));
        more.back().result->aborted = true;
    }
    const Table alone = metricTable(*cohort[0].result, cohort), with = metricTable(*cohort[0].result, more);
    EXPECT_EQ(alone.rows, with.rows);
    const auto own = [](const std::vector<stylet::records::StoredAttempt>& all) {
        std::vector<stylet::records::StoredAttempt> of_b;
        for (const auto& attempt : all)
            if (attempt.info.trainee == "trainee-B") of_b.push_back(attempt);
        return of_b;
    };
    const std::string before = traineeReport("trainee-B", own(cohort), cohort).html;
    const std::string after = traineeReport("trainee-B", own(more), more).html;
    EXPECT_TRUE(has(after, "15 attempts, 5 of them finished; 9 aborted"));
    for (const char* section : {"Learning curve</h2>", "CUSUM</h2>"})
        EXPECT_EQ(textFrom(before, section, "<h2"), textFrom(after, section, "<h2")) << section;
    const std::string all = cohortReport("all", more).html, less = cohortReport("all", cohort).html;
    EXPECT_EQ(textFrom(all, "Metrics</h2>", "<h2"), textFrom(less, "Metrics</h2>", "<h2"));
    EXPECT_TRUE(has(textFrom(all, "gone0</th>", "</tr>"), ">aborted</td>"));
}

TEST(Debrief, RestartedAndImportedAttemptsEnterNoStatistics) {
    std::vector<stylet::records::StoredAttempt> own;
    for (const char* id : {"restarted0", "imported0", "own0"})
        own.push_back(stylet::test::makeTestAttempt(id, "trainee-B", 100.0, true));
    own[0].events.insert(own[0].events.begin(), {0, "retry", "another attempt until bookmark 2"});
    own[1].imported = true;
    const GroupReport page = traineeReport("trainee-B", own, own);
    EXPECT_TRUE(has(page.html,
                    "3 attempts, 1 of them finished; 1 restarted, 1 imported, listed but not part of the "
                    "statistics"));
    EXPECT_TRUE(has(textFrom(page.html, "restarted0</th>", "</tr>"), ">restarted</td>"));
    EXPECT_TRUE(has(textFrom(page.html, "imported0</th>", "</tr>"), ">imported</td>"));
    const std::size_t counts =
        std::size_t(std::ranges::find(page.attempts.head, "counts") - page.attempts.head.begin());
    ASSERT_LT(counts, page.attempts.head.size());
    EXPECT_EQ(page.attempts.rows[0][counts] + page.attempts.rows[1][counts] + page.attempts.rows[2][counts],
              "001");
    EXPECT_TRUE(has(cohortReport("all", own).html, "1 restarted, 1 imported"));

    const TempFolder folder;
    LoadedAttempt a = makeOneStepAttempt(folder);
    a.stored.imported = true;
    EXPECT_TRUE(has(attemptReport(a, {}).html, "State: imported: it enters no statistics"));
}

// Killing the program must not hide a failing exam.
TEST(Debrief, AnExamThatWasCutShortIsShownAsNotPassed) {
    auto exam = stylet::test::makeTestAttempt("exam0", "trainee-B", 0.0, false);
    exam.info.difficulty = "exam";
    exam.state = stylet::records::AttemptState::cut_short;
    exam.result.reset();
    exam.events.push_back({51000, "critical", "the lung was punctured"});
    std::vector<stylet::records::StoredAttempt> own{exam};
    const std::string alone = traineeReport("trainee-B", own, own).html;
    EXPECT_TRUE(has(alone, "1 attempt, 0 of them finished; 1 exam cut short, not passed."));
    EXPECT_TRUE(has(alone, "CUSUM of failures over 0 finished attempts and 1 exam cut short"));
    EXPECT_TRUE(has(alone, "no, cut short"));
    EXPECT_TRUE(has(textFrom(alone, "exam0</th>", "</tr>"), ">cut short, not passed</td>"));
    own.push_back(stylet::test::makeTestAttempt("exam1", "trainee-B", 100.0, true));
    own.back().info.difficulty = "exam";
    EXPECT_TRUE(has(traineeReport("trainee-B", own, own).html, "exams passed"));
    EXPECT_TRUE(has(cohortReport("all", own).html, ">1 of 2</td>"));

    const TempFolder folder;
    stylet::test::writeAttemptFolder(folder.path(), 1000, exam);
    LoadedAttempt a = loadAttempt(folder.path());
    a.stored = exam;
    a.stored.folder = folder.path();
    const std::string page = attemptReport(a, {}).html;
    EXPECT_TRUE(has(page, "<b>Not passed</b><span>exam, cut short</span>"));
    EXPECT_TRUE(has(page, "it counts as an exam that was not passed"));
}

TEST(Debrief, GroupPagesShowWhatDoesNotMatch) {
    const auto cohort = stylet::test::makeTestCohort();
    for (const std::string& html : {traineeReport("trainee-B", cohort, cohort, {"attempt x: altered"}).html,
                                    cohortReport("all", cohort, {"attempt x: altered"}).html}) {
        EXPECT_TRUE(has(html, "What does not match"));
        EXPECT_TRUE(has(html, "attempt x: altered"));
    }
    EXPECT_FALSE(has(cohortReport("all", cohort).html, "What does not match"));
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

TEST(Debrief, CohortRanksByMedian) {
    const auto cohort = stylet::test::makeTestCohort();
    const GroupReport report = cohortReport("Scenario procedure", cohort);
    EXPECT_LT(report.html.find(">trainee-F</th><td"), report.html.find(">trainee-A</th><td"));
    EXPECT_EQ(report.attempts.rows.size(), cohort.size());
    EXPECT_EQ(report.attempts.head.size(), 15u + 3u);
    EXPECT_TRUE(has(cohortReport("Nobody", {}).html, "0 attempts"));
}

// HZ-RECORD-04
TEST(Debrief, TraineePageHasEveryAttempt) {
    const auto cohort = stylet::test::makeTestCohort();
    std::vector<stylet::records::StoredAttempt> own;
    for (const auto& attempt : cohort)
        if (attempt.info.trainee == "trainee-B") own.push_back(attempt);
    const GroupReport report = traineeReport("trainee-B", own, cohort);
    EXPECT_TRUE(has(report.html, "6 attempts, 5 of them finished"));
    EXPECT_TRUE(has(report.html, "cut short"));
    EXPECT_TRUE(has(report.html, "Learning curve") && has(report.html, "exponential law of practice"));
    // Totals of 38.5, 45.5, 43.5 and 59.5 are failures. Each raises the CUSUM by 0.78; the limit is 2.48.
    // 66.5 is a pass.
    EXPECT_TRUE(has(report.html, "last verdict: not yet, with attempt 4."));
    EXPECT_TRUE(has(report.html, "<td class=\"n\">3.12</td>"));
    EXPECT_EQ(report.attempts.rows.size(), 6u);
    EXPECT_TRUE(has(traineeReport("x", {own.back()}, cohort).html, "1 attempt, 0 of them finished"));
}

TEST(Debrief, FolderProvidesTickLengthAndPatient) {
    const TempFolder folder;
    auto attempt = stylet::test::makeTestAttempt("", "", 71.0, true);
    attempt.info.patient_digest = 77, attempt.info.dt_s = 0.00025;
    attempt.events.clear();
    stylet::test::writeAttemptFolder(folder.path(), 1000, attempt);
    const LoadedAttempt a = loadAttempt(folder.path());
    EXPECT_EQ(a.stored.id, folder.path().filename());
    EXPECT_EQ(a.stored.info.dt_s, 0.00025);
    EXPECT_EQ(a.stored.info.patient_digest, 77u);
    EXPECT_TRUE(has(timelineFigure(a).description, "Timeline of 1.0 s."));  // shortest timeline that is drawn
    EXPECT_TRUE(has(timelineFigure(a).description, "in the body for 0.1 s"));
}

// Everything that a report writes, by file name.
std::map<std::string, std::string> reportOf(const std::string& attempt, const std::filesystem::path& records,
                                            const TempFolder& folder) {
    ReportOptions o;
    o.attempt = attempt, o.records = records, o.out = folder / "report";
    std::filesystem::remove_all(o.out);
    reportAttempt(o);
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(o.out))
        files[entry.path().filename().string()] = stylet::test::readText(entry.path());
    return files;
}

// HZ-TEACH-20
TEST(Debrief, ReportsOfAStoredAndAnExportedAttemptAreTheSameBytes) {
    const TempFolder folder;
    stylet::records::Store store(folder / "store");
    const auto made = stylet::test::makeTestAttempt("", "trainee-A", 71.0, true);
    for (const bool torn : {false, true}) {
        const std::string id = store.begin(made.info);
        auto begun = store.attempt(id);
        begun.result = made.result, begun.events = made.events;
        stylet::test::writeAttemptFolder(begun.folder, 5000, begun);
        if (torn) std::ofstream(begun.folder / "record/samples.bin", std::ios::app) << "half a frame";
        store.finish(id);
        const auto stored = reportOf(id, folder / "store", folder);
        EXPECT_EQ(stored.size(), 5u) << "page, course, events, metrics and xAPI";
        EXPECT_EQ(has(stored.at("attempt.html"), "record/samples.bin: 12 bytes behind"), torn);
        const std::filesystem::path taken = folder / (torn ? "taken-torn" : "taken");
        exportAttempts(store, "trainee-A", taken);
        EXPECT_EQ(reportOf((taken / "attempts" / id).string(), "/nonexistent", folder), stored);
        EXPECT_EQ(reportOf(begun.folder.string() + "/", "/nonexistent", folder), stored);
        // Copied again under another name.
        std::filesystem::copy(taken / "attempts" / id, taken / "another name",
                              std::filesystem::copy_options::recursive);
        EXPECT_EQ(reportOf((taken / "another name").string(), "/nonexistent", folder), stored);
    }
}

TEST(Debrief, ExportsBesideTheRecordAreNeverRead) {
    const TempFolder folder;
    const std::filesystem::path attempt = folder / "attempt";
    stylet::test::writeAttemptFolder(attempt, 5000);
    const auto before = reportOf(attempt.string(), "/nonexistent", folder);
    const std::vector<std::string> exports{"summary.json", "force-depth.csv",  "force-depth.png",
                                           "slices.png",   "attempt.json",     "flight-1.csv",
                                           "frames.json",  "record/frames.csv"};
    for (const char* text : {"{}", "garbage", R"({"target_hit": false, "score": {"total": 1}})"}) {
        for (const std::string& name : exports)
            std::ofstream(attempt / name) << text;
        EXPECT_EQ(reportOf(attempt.string(), "/nonexistent", folder), before) << text;
    }
    for (const std::string& name : exports)
        std::filesystem::remove(attempt / name);
    EXPECT_EQ(reportOf(attempt.string(), "/nonexistent", folder), before);
    for (const std::string& name : exports)
        std::filesystem::create_directory(attempt / name);
    EXPECT_EQ(reportOf(attempt.string(), "/nonexistent", folder), before);
}

// HZ-RECORD-07
TEST(Debrief, ADamagedRecordIsRefusedWithItsReason) {
    const TempFolder folder;
    const auto refused = [&](const std::string& file, const std::string& field) {
        stylet::test::expectRefused([&] { loadAttempt(folder.path()); }, file, field);
        stylet::test::writeAttemptFolder(folder.path(), 500);
    };
    refused("record.json", "file");  // there is none
    const std::filesystem::path json = folder / "record/record.json", inputs = folder / "record/inputs.bin";
    using stylet::records::kRecordVersion;
    const auto version = [](std::uint32_t number) { return fmt::format("\"format_version\": {}", number); };
    for (const auto& [from, to, field] : std::vector<std::array<std::string, 3>>{
             {"{", "[", "json"},
             {version(kRecordVersion), version(kRecordVersion - 1), "format_version"},
             {"\"target_hit\": true", "\"target_hit\": 1", "result.target_hit"},
             {"\"total\": 71.0", "\"total\": \"71\"", "result.score.total"},
             {"\"kind\": \"tool\"", "\"kind\": 0", "events[0].kind"},
             {"\"lateral_cut_m\"", "\"lateral_cut\"", "result.lateral_cut_m"}}) {
        std::string text = stylet::test::readText(json);
        ASSERT_TRUE(has(text, from)) << from;
        text.replace(text.find(from), from.size(), to);
        std::ofstream(json) << text;
        refused("record.json", field);
    }
    std::filesystem::resize_file(inputs, 20);
    refused("inputs.bin", "header");
    std::string bytes = stylet::test::readText(inputs);
    bytes[20] ^= 1;
    std::ofstream(inputs, std::ios::binary) << bytes;
    refused("inputs.bin", "header");
    std::filesystem::remove(inputs);
    refused("inputs.bin", "file");
    EXPECT_NO_THROW(loadAttempt(folder.path()));
    std::filesystem::remove(folder / "record/samples.bin");
    EXPECT_EQ(loadAttempt(folder.path()).warnings.size(), 1u) << "samples of a finished attempt are missed";
}

TEST(Debrief, RemovesStaleFilesOfAnEarlierReport) {
    const TempFolder folder;
    auto unfinished = stylet::test::makeTestAttempt("", "", 0.0, false);
    unfinished.result.reset();
    stylet::test::writeAttemptFolder(folder / "attempt", 1000, unfinished);
    ReportOptions o;
    o.attempt = (folder / "attempt").string();
    o.out = folder / "out";
    std::filesystem::create_directories(o.out);
    for (const char* name : {"metrics.csv", "xapi.json", "mine.txt"})
        std::ofstream(o.out / name) << "earlier";
    reportAttempt(o);
    EXPECT_FALSE(std::filesystem::exists(o.out / "metrics.csv"));
    EXPECT_FALSE(std::filesystem::exists(o.out / "xapi.json"));
    EXPECT_TRUE(std::filesystem::exists(o.out / "mine.txt"));
    // A folder that is no patient is refused.
    o.patient = folder.path();
    EXPECT_THROW(reportAttempt(o), stylet::DataError);
}

TEST(Debrief, ReportsRecoveredAttempts) {
    const TempFolder folder;
    std::string id;
    {
        stylet::records::Store store(folder.path());
        stylet::records::AttemptInfo info;
        info.trainee = "trainee-A";
        id = store.begin(info);
    }
    ReportOptions o;
    o.records = folder.path(), o.out = folder / "out";
    testing::internal::CaptureStderr();
    reportCohort(o);
    EXPECT_TRUE(
        has(testing::internal::GetCapturedStderr(), "stylet-report: attempt " + id + " was cut short"));
}

// A report on an attempt of ten minutes. Users wait for it and send it by mail, so its time and size matter.
TEST(Debrief, TenMinutesAreReportedInSeconds) {
    const TempFolder folder;
#ifdef STYLET_SANITIZED
    constexpr std::uint64_t kTicks = 60000;
#else
    constexpr std::uint64_t kTicks = 600000;
#endif
    stylet::test::writeAttemptFolder(folder.path(), kTicks);
    const std::clock_t begun = std::clock();
    const LoadedAttempt files = loadAttempt(folder.path());
    const AttemptReport report = attemptReport(files, {});
    const double seconds = double(std::clock() - begun) / CLOCKS_PER_SEC;
    std::printf("%llu ticks: %.2f s of processor time, %.2f MB\n", static_cast<unsigned long long>(kTicks),
                seconds, double(report.html.size()) * 1e-6);
    EXPECT_EQ(files.course.size(), kTicks);
    EXPECT_LT(report.html.size(), 5'000'000u);
#if !defined(STYLET_SANITIZED) && defined(__OPTIMIZE__)
    EXPECT_LT(seconds, 5.0);
#endif
}

}  // namespace
