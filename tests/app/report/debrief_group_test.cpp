// Pages of one trainee and of a cohort, and which attempts enter their statistics.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "app/report/attempt_page.h"
#include "app/report/group_pages.h"
#include "tests/app/report/attempts.h"
#include "tests/app/report/debrief.h"

namespace {

using namespace stylet::report;
using stylet::test::has;
using stylet::test::makeOneStepAttempt;
using stylet::test::TempFolder;
using stylet::test::textFrom;

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

TEST(Debrief, CohortRanksByMedian) {
    const auto cohort = stylet::test::makeTestCohort();
    const GroupReport report = cohortReport("Scenario procedure", cohort);
    EXPECT_LT(report.html.find(">trainee-F</th><td"), report.html.find(">trainee-A</th><td"));
    EXPECT_EQ(report.attempts.rows.size(), cohort.size());
    EXPECT_EQ(report.attempts.head.size(), 15u + 3u);
    EXPECT_TRUE(has(cohortReport("Nobody", {}).html, "0 attempts"));
    EXPECT_FALSE(has(report.html, "cannot be compared"));
    std::vector<stylet::records::StoredAttempt> even;
    for (const char* trainee : {"A", "B", "C"})
        even.push_back(stylet::test::makeTestAttempt(trainee, trainee, *trainee == 'C' ? 40.0 : 70.0, true));
    even[1].info.scenario = "drain";
    const std::string html = cohortReport("all", even).html;
    for (const auto& [trainee, rank] : {std::pair("A", "1"), {"B", "1"}, {"C", "3"}})
        EXPECT_TRUE(has(html, fmt::format(">{}</th><td class=\"n\">{}</td>", trainee, rank))) << trainee;
    EXPECT_TRUE(has(html, "at 2 scenarios (drain, procedure), whose totals cannot be compared"));
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
    EXPECT_TRUE(has(report.html, "The totals do not support it")) << "five totals";
    EXPECT_TRUE(has(report.html, "if no part of it is missing, it has no critical error and its total"));
    // Verdicts that repeat are marked once.
    std::vector<stylet::records::StoredAttempt> failures(12, own.front());
    const std::string marks = textFrom(traineeReport("x", failures, failures).html, "\"marks\":[", "]");
    EXPECT_EQ(marks.find("not yet"), marks.rfind("not yet")) << marks;
    EXPECT_TRUE(has(marks, "not yet"));
    EXPECT_EQ(report.attempts.rows.size(), 6u);
    EXPECT_TRUE(has(traineeReport("x", {own.back()}, cohort).html, "1 attempt, 0 of them finished"));
}

}  // namespace
