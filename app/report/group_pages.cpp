#include "app/report/group_pages.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "app/report/attempt_page.h"
#include "app/report/glossary.h"
#include "app/report/verdict.h"
#include "app/report/xapi.h"
#include "app/training/learning.h"
#include "app/training/score.h"
#include "base/statistics.h"

namespace stylet::report {

using records::AttemptState;
using records::MetricRow;
using records::StoredAttempt;

namespace {

using Attempts = std::vector<StoredAttempt>;

Attempts finishedAttempts(const Attempts& attempts) {
    Attempts done;
    for (const StoredAttempt& attempt : attempts)
        if (records::countsInStatistics(attempt)) done.push_back(attempt);
    return done;
}

// "1 attempt", "2 attempts"
std::string counted(std::size_t count, const std::string& what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

// "; 2 aborted, 1 restarted, listed but not part of the statistics; 1 exam cut short, not passed", or
// nothing.
std::string specialText(const Attempts& attempts) {
    std::string left_out;
    for (const std::string_view state : {"aborted", "restarted", "imported"})
        if (const auto count = std::ranges::count(attempts, state, records::stateText))
            left_out += fmt::format("{}{} {}", left_out.empty() ? "; " : ", ", count, state);
    if (!left_out.empty()) left_out += ", listed but not part of the statistics";
    const auto exams = std::size_t(std::ranges::count_if(attempts, records::isUnfinishedExam));
    return left_out + (exams == 0 ? "" : "; " + counted(exams, "exam") + " cut short, not passed");
}

// "1 of 3": the passed ones of the exams that were begun. A dash if there were none.
std::string examsText(const Attempts& attempts) {
    std::size_t begun = 0, passes = 0;
    for (const StoredAttempt& a : attempts) {
        const bool finished = records::countsInStatistics(a) && a.info.difficulty == "exam";
        begun += finished || records::isUnfinishedExam(a);
        passes += finished && passed(a);
    }
    return begun == 0 ? "–" : fmt::format("{} of {}", passes, begun);
}

struct MetricName {
    std::string id, name, unit;
    std::string title() const { return unit.empty() ? name : name + " [" + unit + "]"; }
};

// In order of first occurrence.
std::vector<MetricName> metricNames(const Attempts& attempts) {
    std::vector<MetricName> names;
    for (const StoredAttempt& attempt : attempts)
        if (attempt.result)
            for (const MetricRow& m : attempt.result->metrics)
                if (std::none_of(names.begin(), names.end(),
                                 [&](const MetricName& n) { return n.id == m.id; }))
                    names.push_back({m.id, metricName(m), m.unit});
    return names;
}

const MetricRow* findMetric(const StoredAttempt& attempt, const std::string& id) {
    if (!attempt.result) return nullptr;
    for (const MetricRow& m : attempt.result->metrics)
        if (m.id == id) return &m;
    return nullptr;
}

std::vector<double> collectTotals(const Attempts& attempts) {
    std::vector<double> totals;
    for (const StoredAttempt& attempt : attempts)
        totals.push_back(attempt.result->total);
    return totals;
}

std::vector<double> collectValues(const Attempts& attempts, const std::string& id) {
    std::vector<double> values;
    for (const StoredAttempt& attempt : attempts)
        if (const MetricRow* m = findMetric(attempt, id)) values.push_back(m->value);
    return values;
}

std::string shareText(std::size_t part, std::size_t all) {
    return all == 0 ? "–" : fixed(100.0 * double(part) / double(all), 0) + " %";
}

std::size_t countHits(const Attempts& attempts) {
    return std::size_t(std::count_if(attempts.begin(), attempts.end(),
                                     [](const StoredAttempt& a) { return a.result->target_hit; }));
}

// Median and quartiles of each metric and of the total.
Table spreadTable(const Attempts& done) {
    Table table{"Each metric over " + counted(done.size(), "finished attempt"),
                {"Metric", "Unit", "Lowest", "Lower quartile", "Median", "Upper quartile", "Highest"},
                {},
                {false, false, true, true, true, true, true},
                true};
    const auto row = [&](const std::string& name, const std::string& unit,
                         const std::vector<double>& values) {
        table.rows.push_back({name, unit});
        const double most = quantile(values, 1.0);
        const int digits = std::isfinite(most) && std::fabs(most) < 10.0 ? 2 : 1;
        for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
            table.rows.back().push_back(fixed(quantile(values, share), digits));
    };
    row("Total", "of 100", collectTotals(done));
    for (const MetricName& name : metricNames(done))
        row(name.name, name.unit, collectValues(done, name.id));
    return table;
}

// Axis over a trainee's attempts, numbered from 1.
FigureAxis attemptAxis(std::size_t count, double from, const char* name = "finished attempt") {
    FigureAxis axis{name, from, double(count) + 0.5};
    axis.whole = true;
    return axis;
}

DescribedFigure learningFigure(const Attempts& done) {
    DescribedFigure f;
    const std::vector<double> totals = collectTotals(done);
    const std::optional<training::LearningCurve> curve = training::learningCurve(totals);
    f.figure.x = attemptAxis(done.size(), 0.5);
    f.figure.y = {"total, of 100", 0.0, 100.0};
    f.figure.lines = {{training::kPassMark, "pass mark " + fixed(training::kPassMark, 0)}};
    FigureSeries own{"total", kBlue}, fit{"learning curve", kVermilion};
    own.shape = "circle", fit.dash = {8, 4};
    f.data = {"totals, attempt by attempt",
              {"Attempt", "Begun", "Duct hit", "Total", "Learning curve"},
              {},
              {true, false, false, true, true}};
    for (std::size_t i = 0; i < done.size(); ++i) {
        own.points.push_back({double(i + 1), totals[i]});
        f.data.rows.push_back({std::to_string(i + 1), dateText(done[i].started_utc),
                               done[i].result->target_hit ? "yes" : "no", fixed(totals[i], 1),
                               curve ? fixed(curve->at(i), 1) : "–"});
    }
    f.figure.series = {own};
    f.description = fmt::format("Total over {}, from {} to {}.", counted(done.size(), "finished attempt"),
                                fixed(totals.front(), 1), fixed(totals.back(), 1));
    f.caption = "The total of each finished attempt.";
    if (!curve) {
        f.caption += " A learning curve needs at least four attempts with different totals.";
        return f;
    }
    constexpr int kPerAttempt = 8;
    const int points = kPerAttempt * int(done.size() - 1);
    for (int i = 0; i <= points; ++i) {
        const double n = double(i) / kPerAttempt;
        fit.points.push_back({1.0 + n, curve->plateau - curve->gain * std::exp(-n / curve->rate)});
    }
    f.figure.series.push_back(fit);
    f.caption += " Dashed: the exponential law of practice, fitted; it leaves " + fixed(curve->rms, 1) +
                 " points (root mean square).";
    if (!curve->supported)
        f.caption +=
            " The totals do not support it: they are too few, or vary too much, to tell it from "
            "their mean.";
    else if (curve->gain > 0.0 && curve->plateau <= 100.0 && curve->rate < double(done.size()))
        f.caption += fmt::format(" It approaches {}; the gap to it falls to a third in about {} attempts.",
                                 fixed(curve->plateau, 1), fixed(curve->rate, 1));
    return f;
}

bool failed(const StoredAttempt& attempt) {
    return !passed(attempt);
}

// `judged`: the finished attempts, and the exams that were cut short, which are failures.
DescribedFigure cusumFigure(const Attempts& judged) {
    const auto exams = std::size_t(std::ranges::count_if(judged, records::isUnfinishedExam));
    const std::string all = counted(judged.size() - exams, "finished attempt") +
                            (exams == 0 ? "" : " and " + counted(exams, "exam") + " cut short");
    DescribedFigure f;
    const training::CusumSettings settings;
    const training::CusumLimits limits = training::cusumLimits(settings);
    std::vector<bool> failures;
    for (const StoredAttempt& attempt : judged)
        failures.push_back(failed(attempt));
    const std::vector<training::CusumPoint> points = training::cusum(failures, settings);
    f.figure.x = attemptAxis(judged.size(), 0.0,
                             exams == 0 ? "finished attempt" : "finished attempt or exam cut short");
    f.figure.y = {"CUSUM of failures"};
    FigureSeries line{"CUSUM", kBlue}, lower{"below: competent", kGreen}, upper{"above: not yet", kVermilion};
    line.shape = "circle", lower.dash = {8, 4}, upper.dash = {2, 3};
    line.points.push_back({0.0, 0.0});
    f.data = {"the CUSUM, attempt by attempt",
              {"Attempt", "Passed", "CUSUM", "Competent below", "Not yet above", "Verdict"},
              {},
              {true, false, true, true, true, false}};
    double began = 0.0;
    std::string last = "no verdict yet", verdict_shown;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [height, verdict] = points[i];
        const double x = double(i + 1);
        line.points.push_back({x, height});
        for (const double end : {x - 1.0, x}) {
            lower.points.push_back({end, began - limits.lower_h});
            upper.points.push_back({end, began + limits.upper_h});
        }
        std::string text;
        if (verdict != training::Verdict::open) {
            text = verdict == training::Verdict::competent ? "competent" : "not yet";
            // Repeated verdicts would cover each other.
            if (text != verdict_shown) f.figure.marks.push_back({x, height, text});
            verdict_shown = text;
            last = "last verdict: " + text + ", with attempt " + std::to_string(i + 1);
        }
        const char* passes = records::isUnfinishedExam(judged[i]) ? "no, cut short"
                             : failures[i]                        ? "no"
                                                                  : "yes";
        f.data.rows.push_back({std::to_string(i + 1), passes, fixed(height, 2),
                               fixed(began - limits.lower_h, 2), fixed(began + limits.upper_h, 2),
                               text.empty() ? "–" : text});
        if (!text.empty()) began = height;
    }
    f.figure.series = {line, lower, upper};
    double low = 0.0, high = 0.0;
    for (const FigureSeries& series : f.figure.series)
        for (const FigurePoint& p : series.points)
            low = std::min(low, p.y), high = std::max(high, p.y);
    f.figure.y.min = std::floor(low), f.figure.y.max = std::ceil(high);
    f.description = fmt::format("CUSUM of failures over {}: {}.", all, last);
    f.caption = fmt::format(
        "An attempt is passed, as an exam would be, if no part of it is missing, it has no critical error "
        "and "
        "its total is at least {:.0f}. The line rises with each failure and falls with each pass. An exam "
        "that was cut short after something that the score counts is a failure. Below the lower limit, at "
        "most {:.0f} % of the attempts fail (competent). Above the upper limit, at least {:.0f} % fail. Each "
        "verdict is wrong with a probability of {:.0f} % and restarts the count. So far: {}.",
        training::kPassMark, 100.0 * settings.acceptable, 100.0 * settings.unacceptable,
        100.0 * settings.alpha, last);
    return f;
}

// Metrics over a trainee's numbered attempts.
DescribedFigure metricsFigure(const Attempts& done) {
    DescribedFigure f;
    f.figure.x = attemptAxis(done.size(), 0.5);
    f.figure.low = true;
    f.data = {"all metrics, attempt by attempt", {"Metric"}, {}, {false}};
    for (std::size_t i = 0; i < done.size(); ++i)
        f.data.head.push_back(std::to_string(i + 1)), f.data.number.push_back(true);
    for (const MetricName& name : metricNames(done)) {
        FigureSeries series{name.name, kBlue};
        series.shape = "circle", series.width = 1.5;
        f.data.rows.push_back({name.title()});
        for (std::size_t i = 0; i < done.size(); ++i) {
            const MetricRow* m = findMetric(done[i], name.id);
            const double value = m && std::isfinite(m->value) ? m->value : kGap;
            series.points.push_back({double(i + 1), value});
            f.data.rows.back().push_back(m ? metricText(m->value) : "–");
        }
        f.figure.choices.push_back({name.name, {name.title()}, {series}});
    }
    f.description = fmt::format("One metric over {}, as chosen.", counted(done.size(), "attempt"));
    f.caption = "A metric over the finished attempts, as chosen.";
    return f;
}

struct TraineeStatistics {
    std::string trainee;
    Attempts all, done;
    double median_total = 0.0;
};

// Sorted by median total, best first.
std::vector<TraineeStatistics> groupByTrainee(const Attempts& attempts) {
    std::map<std::string, TraineeStatistics> by_name;
    for (const StoredAttempt& attempt : attempts) {
        TraineeStatistics& person = by_name[attempt.info.trainee];
        person.trainee = attempt.info.trainee;
        person.all.push_back(attempt);
        if (records::countsInStatistics(attempt)) person.done.push_back(attempt);
    }
    std::vector<TraineeStatistics> trainees;
    for (auto& [name, person] : by_name) {
        person.median_total = median(collectTotals(person.done));
        trainees.push_back(std::move(person));
    }
    const auto rank = [](const TraineeStatistics& p) {
        return std::isnan(p.median_total) ? -1.0 : p.median_total;
    };
    std::sort(trainees.begin(), trainees.end(), [&](const TraineeStatistics& a, const TraineeStatistics& b) {
        return rank(a) != rank(b) ? rank(a) > rank(b) : a.trainee < b.trainee;
    });
    return trainees;
}

// One value per attempt, one column per trainee, with each trainee's median.
FigureChoice stripPlot(const std::string& name, const std::string& axis,
                       const std::vector<TraineeStatistics>& trainees,
                       const std::vector<std::vector<double>>& values) {
    FigureSeries points{"attempt", kBlue}, medians{"median", kVermilion};
    points.line = medians.line = false;
    points.shape = "circle", medians.shape = "line";
    for (std::size_t p = 0; p < trainees.size(); ++p) {
        for (std::size_t i = 0; i < values[p].size(); ++i) {
            // Spread the points horizontally in order, so that equal values do not hide one another.
            const double count = double(values[p].size());
            const double x = double(p) + (count < 2.0 ? 0.0 : 0.5 * (double(i) / (count - 1.0) - 0.5));
            if (std::isfinite(values[p][i]))
                points.points.push_back(
                    {x, values[p][i], trainees[p].trainee + " " + metricText(values[p][i])});
        }
        const double middle = median(values[p]);
        if (std::isfinite(middle))
            medians.points.push_back({double(p), middle, trainees[p].trainee + " " + metricText(middle)});
    }
    return {name, {axis}, {medians, points}};  // the first series is drawn on top
}

DescribedFigure cohortFigure(const std::vector<TraineeStatistics>& trainees, const Attempts& done) {
    DescribedFigure f;
    for (const TraineeStatistics& person : trainees)
        f.figure.x.names.push_back(person.trainee);
    std::vector<std::vector<double>> totals;
    for (const TraineeStatistics& person : trainees)
        totals.push_back(collectTotals(person.done));
    f.figure.choices.push_back(stripPlot("Total", "total, of 100", trainees, totals));
    f.figure.choices.back().y.min = 0.0, f.figure.choices.back().y.max = 100.0;
    f.data = {"median of each metric, trainee by trainee", {"Metric"}, {}, {false}};
    for (const TraineeStatistics& person : trainees)
        f.data.head.push_back(person.trainee), f.data.number.push_back(true);
    f.data.rows.push_back({"Total"});
    for (const TraineeStatistics& person : trainees)
        f.data.rows.back().push_back(fixed(person.median_total, 1));
    for (const MetricName& name : metricNames(done)) {
        std::vector<std::vector<double>> values;
        f.data.rows.push_back({name.title()});
        for (const TraineeStatistics& person : trainees) {
            values.push_back(collectValues(person.done, name.id));
            f.data.rows.back().push_back(metricText(median(values.back())));
        }
        f.figure.choices.push_back(stripPlot(name.name, name.title(), trainees, values));
    }
    f.description =
        fmt::format("Total or a metric, as chosen, of every finished attempt of {}, with the median of each.",
                    counted(trainees.size(), "trainee"));
    if (!trainees.empty() && !std::isnan(trainees[0].median_total))
        f.description += fmt::format(" Highest median total: {} with {}.", trainees[0].trainee,
                                     fixed(trainees[0].median_total, 1));
    f.caption = "Every finished attempt, in each trainee's column from first to last; bars: medians.";
    return f;
}

Table rankingTable(const std::vector<TraineeStatistics>& trainees) {
    Table table{"Trainees by median total",
                {"Trainee", "Rank", "Attempts", "Finished", "Exams passed", "Median total", "Best total",
                 "Last total", "Duct hit"},
                {},
                {false, true, true, true, false, true, true, true, true},
                true};
    std::size_t rank = 0;
    double above = kGap;
    for (const TraineeStatistics& person : trainees) {
        const std::vector<double> totals = collectTotals(person.done);
        if (person.median_total != above) rank = table.rows.size() + 1;  // equal medians share a rank
        above = person.median_total;
        table.rows.push_back({person.trainee, person.done.empty() ? "–" : std::to_string(rank),
                              std::to_string(person.all.size()), std::to_string(person.done.size()),
                              examsText(person.all), fixed(person.median_total, 1),
                              fixed(quantile(totals, 1.0), 1),
                              fixed(totals.empty() ? kGap : totals.back(), 1),
                              shareText(countHits(person.done), person.done.size())});
    }
    return table;
}

Table shortTable(const Attempts& attempts) {
    Table table{"All attempts",
                {"Attempt", "Begun", "Scenario", "Difficulty", "State", "Minutes", "Duct hit", "Total"},
                {},
                {false, false, false, false, false, true, false, true},
                true};
    for (const StoredAttempt& a : attempts)
        table.rows.push_back({a.id, dateText(a.started_utc), a.info.scenario, a.info.difficulty,
                              std::string(records::stateText(a)),
                              a.result ? fixed(double(a.result->ticks) * a.info.dt_s / 60.0, 1) : "–",
                              a.result ? (a.result->target_hit ? "yes" : "no") : "–",
                              a.result ? fixed(a.result->total, 1) : "–"});
    return table;
}

}  // namespace

Table attemptsTable(const Attempts& attempts) {
    Table table;
    table.head = {"attempt", "trainee", "begun_utc",  "state", "scenario", "difficulty",    "patient", "seed",
                  "device",  "ticks",   "target_hit", "total", "aborted",  "score_version", "counts"};
    table.number = {false, false, false, false, false, false, false, true,
                    false, true,  true,  true,  true,  true,  true};
    const std::vector<MetricName> names = metricNames(attempts);
    for (const MetricName& name : names)
        table.head.push_back(name.unit.empty() ? name.id : name.id + " [" + name.unit + "]"),
            table.number.push_back(true);
    for (const StoredAttempt& a : attempts) {
        table.rows.push_back({a.id, a.info.trainee, a.started_utc, std::string(records::stateName(a.state)),
                              a.info.scenario, a.info.difficulty, a.info.patient, std::to_string(a.info.seed),
                              a.info.device, a.result ? std::to_string(a.result->ticks) : "",
                              a.result ? (a.result->target_hit ? "1" : "0") : "",
                              a.result ? fixed(a.result->total, 3) : "",
                              a.result ? (a.result->aborted ? "1" : "0") : "",
                              a.result ? std::to_string(a.result->score_version) : "",
                              records::countsInStatistics(a) ? "1" : "0"});
        for (const MetricName& name : names) {
            const MetricRow* m = findMetric(a, name.id);
            table.rows.back().push_back(m && std::isfinite(m->value) ? fixed(m->value, 6) : "");
        }
    }
    return table;
}

namespace {

// The totals of different scenarios cannot be compared.
void addScenarios(Page& page, const Attempts& done) {
    std::set<std::string> names;
    for (const StoredAttempt& attempt : done)
        names.insert(attempt.info.scenario);
    if (names.size() > 1)
        page.paragraph(fmt::format(
            "These attempts are at {} scenarios ({}), whose totals cannot be compared: use --scenario "
            "to see one of them.",
            names.size(), fmt::join(names, ", ")));
}

// `warnings`: from records::findAlteredRows().
void addWarnings(Page& page, const std::vector<std::string>& warnings) {
    if (warnings.empty()) return;
    page.section("What does not match");
    for (const std::string& warning : warnings)
        page.paragraph(warning);
}

}  // namespace

GroupReport traineeReport(const std::string& trainee, const Attempts& attempts, const Attempts& cohort,
                          const std::vector<std::string>& warnings) {
    const Attempts done = finishedAttempts(attempts), all = finishedAttempts(cohort);
    Attempts judged;
    for (const StoredAttempt& attempt : attempts)
        if (records::countsInStatistics(attempt) || records::isUnfinishedExam(attempt))
            judged.push_back(attempt);
    const std::vector<double> totals = collectTotals(done);
    Page page("Trainee " + trainee, counted(attempts.size(), "attempt") + ", " + std::to_string(done.size()) +
                                        " of them finished" + specialText(attempts) + ".");
    page.headlines(
        {{std::to_string(done.size()), done.size() == 1 ? "finished attempt" : "finished attempts"},
         {fixed(totals.empty() ? kGap : totals.back(), 1), "last total of 100"},
         {fixed(quantile(totals, 1.0), 1), "best total"},
         {shareText(countHits(done), done.size()), "bile duct hit"},
         {examsText(attempts), "exams passed"}});
    addScenarios(page, done);
    addWarnings(page, warnings);
    if (!done.empty()) {
        page.section("Learning curve");
        page.figure(learningFigure(done));
    }
    if (!judged.empty()) {
        page.section("CUSUM");
        page.figure(cusumFigure(judged));
    }
    if (!done.empty()) {
        page.section("Metrics");
        const DescribedFigure metrics = metricsFigure(done);
        if (!metrics.figure.choices.empty()) page.figure(metrics);
        page.paragraph("The last finished attempt, against the " + counted(all.size(), "finished attempt") +
                       " of all trainees in these records:");
        page.table(metricTable(*done.back().result, all));
    }
    page.section("Attempts");
    page.table(shortTable(attempts));
    addGlossary(page);
    return {page.html(), attemptsTable(attempts)};
}

GroupReport cohortReport(const std::string& what, const Attempts& attempts,
                         const std::vector<std::string>& warnings) {
    const Attempts done = finishedAttempts(attempts);
    const std::vector<TraineeStatistics> trainees = groupByTrainee(attempts);
    Page page("Cohort", what + ": " + counted(attempts.size(), "attempt") + " of " +
                            counted(trainees.size(), "trainee") + ", by pseudonym" + specialText(attempts) +
                            ".");
    page.headlines(
        {{std::to_string(trainees.size()), trainees.size() == 1 ? "trainee" : "trainees"},
         {std::to_string(done.size()), done.size() == 1 ? "finished attempt" : "finished attempts"},
         {fixed(median(collectTotals(done)), 1), "median total of 100"},
         {shareText(countHits(done), done.size()), "bile duct hit"},
         {examsText(attempts), "exams passed"}});
    addScenarios(page, done);
    addWarnings(page, warnings);
    if (!trainees.empty()) {
        page.section("Trainees");
        page.figure(cohortFigure(trainees, done));
        page.table(rankingTable(trainees));
    }
    if (!done.empty()) {
        page.section("Metrics");
        page.table(spreadTable(done));
    }
    page.section("Attempts");
    page.table(shortTable(attempts));
    addGlossary(page);
    return {page.html(), attemptsTable(attempts)};
}

}  // namespace stylet::report
