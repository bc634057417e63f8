// What a debrief says about an attempt's score: whether an exam is passed, and the advice.
#include <gtest/gtest.h>

#include "app/report/advice.h"
#include "app/report/attempt_page.h"
#include "app/report/verdict.h"
#include "tests/app/report/attempts.h"
#include "tests/app/report/debrief.h"

namespace {

using namespace stylet::report;
using stylet::test::has;
using stylet::test::makeOneStepAttempt;
using stylet::test::TempFolder;
using stylet::test::textFrom;

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

}  // namespace
