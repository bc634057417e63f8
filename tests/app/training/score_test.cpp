#include "app/training/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include "app/training/metrics.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/training/wall.h"
#include "tests/support/constants.h"
#include "tests/support/seed.h"

namespace stylet::training {
namespace {

using test::kNaN;

constexpr double kInf = std::numeric_limits<double>::infinity();

MetricValues allAt(double Metric::* end) {
    MetricValues values{};
    for (std::size_t i = 0; i < kMetricCount; ++i)
        values[i] = metricTable()[i].*end;
    return values;
}

TEST(Score, BestValuesScoreOneHundredAndWorstZero) {
    EXPECT_EQ(computeScore(allAt(&Metric::best), kAllSteps).total, 100.0);
    for (const Course course : {Course::puncture, Course::drainage}) {
        EXPECT_NEAR(computeScore(allAt(&Metric::best), kAllSteps, course).total, 100.0, 1e-9);
        EXPECT_EQ(computeScore(allAt(&Metric::worst), kAllSteps, course).total, 0.0);
    }
}

// A puncture has no anaesthesia, and is scored as before there was any.
TEST(Score, MetricsOfTheDrainageCountInADrainageOnly) {
    for (const MetricId id :
         {MetricId::pain, MetricId::anaesthetic, MetricId::tornTrack, MetricId::caseReview}) {
        MetricValues values = allAt(&Metric::best);
        values[std::size_t(id)] = metricTable()[std::size_t(id)].worst;
        EXPECT_EQ(computeScore(values, kAllSteps).total, 100.0);
        EXPECT_EQ(computeScore(values, kAllSteps).max_points[std::size_t(id)], 0.0);
        EXPECT_LT(computeScore(values, kAllSteps, Course::drainage).total, 99.2);
    }
}

// A drainage recorded before there were cases gets no points for a review that nobody asked for.
// HZ-TEACH-01
TEST(Score, WithoutACaseTheReviewIsNotScored) {
    constexpr auto kReview = std::size_t(MetricId::caseReview);
    MetricValues values = allAt(&Metric::best);
    Score score = computeScore(values, kAllSteps, Course::drainage, false);
    EXPECT_NEAR(score.total, 100.0, 1e-9);
    EXPECT_EQ(score.max_points[kReview], 0.0);
    EXPECT_EQ(score.points[kReview], 0.0);
    const std::size_t targeting = std::size_t(MetricId::targeting);
    values[targeting] = metricTable()[targeting].worst;
    score = computeScore(values, kAllSteps, Course::drainage, false);
    EXPECT_LT(score.total, computeScore(values, kAllSteps, Course::drainage).total)
        << "the others weigh more, as before there were cases";
    EXPECT_NEAR(100.0 - score.total, 100.0 * 10.0 / (weightSum(Course::drainage) - 5.0), 1e-9);
}

// HZ-TEACH-01
TEST(Score, HalfwayValueEarnsHalfAndPointsAddUp) {
    MetricValues values = allAt(&Metric::best);
    const std::size_t i = std::size_t(MetricId::targeting);
    const Metric& m = metricTable()[i];
    values[i] = 0.5 * (m.best + m.worst);
    const Score score = computeScore(values, kAllSteps);
    EXPECT_DOUBLE_EQ(score.points[i], 0.5 * m.weight);
    EXPECT_DOUBLE_EQ(score.total, 100.0 - 0.5 * m.weight);
    double sum = 0.0;
    for (const double points : score.points)
        sum += points;
    EXPECT_EQ(score.total, sum);
}

TEST(Score, IdleTraineeEarnsNoPoints) {
    MetricValues values = allAt(&Metric::best);
    values[std::size_t(MetricId::procedure)] = 0.0;
    EXPECT_EQ(computeScore(values, kAllSteps).total, 0.0);
    values[std::size_t(MetricId::procedure)] = 50.0;
    EXPECT_NEAR(computeScore(values, kAllSteps).total, 50.0 - 0.5 * 0.5 * 8.0, 1e-12);
}

// A metric of a step that was left out earns nothing, however good its value.
// HZ-TEACH-01
TEST(Score, StepLeftOutEarnsNothing) {
    const MetricValues best = allAt(&Metric::best);
    for (int step = 0; step < kStepCount; ++step) {
        const Score score = computeScore(best, kAllSteps & ~(1u << step), Course::drainage);
        for (std::size_t i = 0; i < kMetricCount; ++i)
            EXPECT_EQ(score.points[i], metricTable()[i].needs == Step(step) ? 0.0 : score.max_points[i])
                << metricTable()[i].id;
    }
    EXPECT_LT(computeScore(best, kAllSteps & ~(1u << unsigned(Step::advance))).total, 40.0);
}

// Starts from random attempts. Replacing a metric by any worse value, or by NaN, never raises the total. The
// points of each metric stay between 0 and its weight.
// HZ-TEACH-01
TEST(Score, WorseningAnyMetricNeverRaisesTheTotal) {
    std::mt19937_64 random(test::seed());
    std::uniform_real_distribution<double> share(-0.3, 1.3), more(0.0, 2.0), one(0.0, 1.0);
    int lowered = 0;
    for (int n = 0; n < 4000; ++n) {
        MetricValues values{};
        for (std::size_t i = 0; i < kMetricCount; ++i) {
            const Metric& m = metricTable()[i];
            values[i] = m.best + (m.worst - m.best) * share(random);
            if (one(random) < 0.02)
                values[i] = one(random) < 0.5 ? kNaN : m.best + (m.worst - m.best) * 1e300;
        }
        const Score before = computeScore(values, kAllSteps, Course::drainage);
        ASSERT_TRUE(before.total >= 0.0 && before.total <= 100.0 + 1e-9) << before.total;
        for (std::size_t i = 0; i < kMetricCount; ++i) {
            const Metric& m = metricTable()[i];
            ASSERT_TRUE(before.points[i] >= 0.0 && before.points[i] <= m.weight) << m.id;
            const double towards_worst = m.worst > m.best ? 1.0 : -1.0;
            for (const double worse :
                 {values[i] + towards_worst * more(random) * std::fabs(m.worst - m.best),
                  std::nextafter(values[i], towards_worst * kInf), towards_worst * kInf, kNaN}) {
                MetricValues worsened = values;
                worsened[i] = worse;
                const double total = computeScore(worsened, kAllSteps, Course::drainage).total;
                ASSERT_LE(total, before.total) << m.id << ": " << values[i] << " -> " << worse;
                lowered += total < before.total;
                // Conversely, a better value never lowers the total.
                if (std::isnan(values[i])) continue;
                MetricValues bettered = values;
                bettered[i] = values[i] - (worse - values[i]);
                if (!std::isfinite(bettered[i])) continue;
                ASSERT_GE(computeScore(bettered, kAllSteps, Course::drainage).total, before.total) << m.id;
            }
        }
    }
    EXPECT_GT(lowered, 10000) << "no metric does anything";
}

// HZ-TEACH-01
TEST(Score, EveryMetricCounts) {
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        MetricValues values = allAt(&Metric::best);
        values[i] = metricTable()[i].worst;
        EXPECT_LT(computeScore(values, kAllSteps, Course::drainage).total, 99.2) << metricTable()[i].id;
    }
}

// Value of one metric after a number of equal ticks.
double valueAfter(MetricId id, const haptics::TickOutput& now, int ticks) {
    static const patient::Package package = test::wallWithVessel();
    static const patient::Patient patient(package);
    const AttemptFold fold(patient, test::kDt_s);
    Metrics metrics(test::wallPath(), std::nullopt, test::kDt_s);
    for (int i = 0; i < ticks; ++i)
        metrics.update(now, {}, fold);
    return metrics.values()[std::size_t(id)];
}

TEST(Metric, TimesCountTicksAndPeaksKeepTheLargest) {
    haptics::TickOutput now;
    EXPECT_EQ(valueAfter(MetricId::probeTime, now, 1000), 0.0);
    now.tool = haptics::Tool::probe, now.probe_touching_share = 0.5;
    EXPECT_NEAR(valueAfter(MetricId::probeTime, now, 1000), 1.0, 1e-9);
    now.force_n = -2.0, now.lateral_cut_m = 0.003;
    EXPECT_EQ(valueAfter(MetricId::peakForce, now, 2), 2.0);
    EXPECT_EQ(valueAfter(MetricId::lateralCut, now, 2), 3.0);
}

std::string numberText(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

// The table in the guide's metrics.md has one line per metric.
// HZ-TEACH-01
TEST(Score, GuideTableMatchesTheMetricTable) {
    std::ifstream page(test::assets().parent_path() / "packaging" / "guide" / "metrics.md");
    ASSERT_TRUE(page);
    std::vector<std::string> rows;
    for (std::string line; std::getline(page, line) && line != "# The study of force errors";)
        if (line.starts_with("| `")) rows.push_back(line);
    ASSERT_EQ(rows.size(), kMetricCount);
    std::set<std::string_view> ids;
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        const Metric& m = metricTable()[i];
        std::ostringstream row;
        row << "| `" << m.id << "` | " << m.name << " | " << m.unit << " | " << m.what << " | " << m.source
            << " | " << numberText(m.weight) << " | " << numberText(m.best) << " | " << numberText(m.worst)
            << " | " << (m.needs == Step::done ? "" : stepName(m.needs)) << " |";
        EXPECT_EQ(rows[i], row.str());
        EXPECT_TRUE(ids.insert(m.id).second) << m.id;
    }
}

// The event kinds in the row `kind` of the guide's table.
TEST(Progress, GuideListsAllEventKinds) {
    std::ifstream page(test::assets().parent_path() / "packaging" / "guide" / "records.md");
    ASSERT_TRUE(page);
    std::string row;
    for (bool events = false; std::getline(page, row) && !(events && row.starts_with("| `kind` |"));)
        events = events || row == "## `event`";
    ASSERT_TRUE(page) << "no row of kinds";
    std::vector<std::string> told;
    std::string name;
    std::istringstream cells(row.substr(row.find("| ", 2)));
    for (bool inside = false; std::getline(cells, name, '`'); inside = !inside)
        if (inside) told.push_back(name);
    EXPECT_EQ(told, (std::vector<std::string>(kEventKinds.begin(), kEventKinds.end())));
}

}  // namespace
}  // namespace stylet::training
