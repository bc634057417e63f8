#include "app/report/advice.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "app/report/verdict.h"

namespace stylet::report {

using training::MetricId;

namespace {

constexpr double kAround_s = 10.0;  // of the timeline, before and after the moment

using Rows = std::vector<CourseRow>;
using When = std::optional<double>;  // s; none: not found in the record

template <typename Test>
When findRow(const LoadedAttempt& a, const Test& test) {
    const auto row = std::find_if(a.course.begin(), a.course.end(), test);
    return row == a.course.end() ? When() : row->t_s;
}

// The row in the body with the largest value.
template <typename Value>
When findLargest(const LoadedAttempt& a, const Value& value) {
    const CourseRow* best = nullptr;
    for (const CourseRow& row : a.course)
        if (row.in_body && std::isfinite(value(row)) && (!best || value(row) > value(*best))) best = &row;
    return best ? When(best->t_s) : When();
}

// The event of this kind with the given index.
When findEvent(const LoadedAttempt& a, std::string_view kind, std::size_t index = 0) {
    for (const records::EventRow& event : a.stored.events)
        if (event.kind == kind && index-- == 0) return double(event.tick) * a.stored.info.dt_s;
    return {};
}

When findLastStep(const LoadedAttempt& a) {
    When last;
    for (std::size_t i = 0; const When step = findEvent(a, "step", i); ++i)
        last = step;
    return last;
}

When findOutOfOrder(const LoadedAttempt& a) {
    for (const records::EventRow& event : a.stored.events)
        if (event.kind == "step" && event.text.find("after a later one") != std::string::npos)
            return double(event.tick) * a.stored.info.dt_s;
    return findLastStep(a);
}

When findEntry(const LoadedAttempt& a) {
    return findRow(a, [](const CourseRow& row) { return row.in_body; });
}

When findKey(const LoadedAttempt& a) {
    const std::optional<std::size_t> row = keyRow(a);
    return row ? When(a.course[*row].t_s) : When();
}

const training::Metric& metric(MetricId id) {
    return training::metricTable()[std::size_t(id)];
}

// The first contact beyond those that cost nothing.
When findContact(const LoadedAttempt& a) {
    return findEvent(a, "contact", std::size_t(metric(MetricId::skinContacts).best));
}

// When the probe had been in hand for as long as costs nothing.
When findProbeTime(const LoadedAttempt& a) {
    double left_s = metric(MetricId::probeTime).best;
    return findRow(a, [&](const CourseRow& row) {
        if (row.tool == haptics::Tool::probe) left_s -= a.stored.info.dt_s;
        return left_s <= 0.0;
    });
}

When findSessionTime(const LoadedAttempt& a) {
    const double best_s = metric(MetricId::sessionTime).best;
    return findRow(a, [&](const CourseRow& row) { return row.t_s >= best_s; });
}

When findBreathing(const LoadedAttempt& a) {
    return findRow(a, [](const CourseRow& row) { return row.in_body && !row.breath_held; });
}

When findLiver(const LoadedAttempt& a) {
    return findRow(a, [](const CourseRow& r) { return r.in_body && r.tissue == patient::Tissue::liver; });
}

When findPeakForce(const LoadedAttempt& a) {
    return findLargest(a, [](const CourseRow& row) { return std::fabs(row.force_n); });
}

When findClosest(const LoadedAttempt& a) {
    return findLargest(a, [](const CourseRow& row) { return -row.clearance_m; });
}

When findHit(const LoadedAttempt& a) {
    const When hit = findEvent(a, "risk");
    return hit ? hit : findClosest(a);
}

// An event's text begins with the pain: "8 of 10: the dilatation".
int painOf(const records::EventRow& event) {
    return std::atoi(event.text.c_str());
}

When findTear(const LoadedAttempt& a) {
    for (const records::EventRow& event : a.stored.events)
        if (event.kind == "refused" && event.text.starts_with("the drain tears"))
            return double(event.tick) * a.stored.info.dt_s;
    return {};
}

When findPain(const LoadedAttempt& a) {
    const records::EventRow* worst = nullptr;
    for (const records::EventRow& event : a.stored.events)
        if (event.kind == "pain" && (!worst || painOf(event) > painOf(*worst))) worst = &event;
    return worst ? When(double(worst->tick) * a.stored.info.dt_s) : When{};
}

When findWrongAnswer(const LoadedAttempt& a) {
    for (const records::EventRow& event : a.stored.events)
        if (event.kind == "answer" && event.text.find(": wrong, ") != std::string::npos)
            return double(event.tick) * a.stored.info.dt_s;
    return findEntry(a);
}

// What to do about a loss, and where in the record it happened.
struct Hint {
    std::string_view id;  // of the metric
    const char* text;
    When (*find)(const LoadedAttempt&);  // null: the value is that of the end
};
constexpr std::array kHints{
    Hint{"procedure", "Do the missing steps too", findLastStep},
    Hint{"out_of_order", "Do the steps in their order", findOutOfOrder},
    Hint{"targeting", "Bring the tip nearer to the target", findKey},
    Hint{"no_go_touches", "Keep the needle out of the no-go areas", findHit},
    Hint{"no_go_time", "Leave a no-go area at once", findHit},
    Hint{"needle_in_beam", "Keep the needle in the ultrasound beam", findEntry},
    Hint{"probe_time", "Find the duct in less time", findProbeTime},
    Hint{"session_time", "Use less time for the whole procedure", findSessionTime},
    Hint{"skin_contacts", "Touch the skin less often", findContact},
    Hint{"needle_path", "Advance the needle in one straight insertion", findKey},
    Hint{"entry_off", "Enter at the planned place", findEntry},
    Hint{"angle_off", "Aim along the planned path before you advance", findEntry},
    Hint{"vessel_hits", "Pass beside the blood vessels", findHit},
    Hint{"bone_hits", "Pass between the ribs", findHit},
    Hint{"lung_hits", "Stay clear of the lung and of gas", findHit},
    Hint{"organ_hits", "Stay clear of the other organs", findHit},
    Hint{"near_misses", "Keep more than 2 mm from every risk structure", findClosest},
    Hint{"clearance", "Keep more distance from risk structures", findClosest},
    Hint{"duct_angle", "Meet the duct less steeply, so that the wire can turn", findKey},
    Hint{"breath_at_capsule", "Enter the liver in the planned phase of the breath", findLiver},
    Hint{"moved_breathing", "Move the needle only in a breath-hold", findBreathing},
    Hint{"lateral_cut", "Do not push the needle sideways in the body", findKey},
    Hint{"fluoroscopy", "Press the X-ray pedal for less time", nullptr},
    Hint{"dose", "Use less radiation: collimate, and lower the pulse rate", nullptr},
    Hint{"contrast", "Inject less contrast medium", nullptr},
    Hint{"contrast_astray", "Inject only while the tip is in the duct", nullptr},
    Hint{"peak_force", "Advance with less force", findPeakForce},
    Hint{"pain", "Numb the whole track, from the skin to the liver's capsule, before you cut", findPain},
    Hint{"anaesthetic", "Inject less local anaesthetic", nullptr},
    Hint{"torn_track", "Dilate the whole track before you take the drain", findTear},
    Hint{"case_review", "Review the case and answer every question before you begin", findWrongAnswer},
};

// A loss with its reason, as the record's version of the table allows.
struct ReasonedLoss {
    std::string id, name, why;
    double points = 0.0, of = 0.0;
};

std::vector<ReasonedLoss> findReasons(const records::AttemptResult& result) {
    std::vector<ReasonedLoss> losses;
    if (const std::optional<training::Score> score = findScore(result)) {
        for (const training::Loss& loss : training::findLosses(*score)) {
            const training::Metric& about = metric(loss.metric.value_or(MetricId::procedure));
            losses.push_back(
                {std::string(about.id), std::string(about.name),
                 loss.metric
                     ? training::describeValue(about, score->values[std::size_t(*loss.metric)])
                     : training::describeMissingSteps(result.steps.done.size(), std::size_t(result.steps.of)),
                 loss.points, loss.of});
        }
        return losses;
    }
    for (const records::MetricRow& row : result.metrics)
        if (row.max_points - row.points >= training::kSmallestLoss)
            losses.push_back({row.id, row.name,
                              std::isfinite(row.value) ? fmt::format("{:.4g}{}{}", row.value,
                                                                     row.unit.empty() ? "" : " ", row.unit)
                                                       : std::string("not achieved"),
                              row.max_points - row.points, row.max_points});
    std::sort(losses.begin(), losses.end(), [](const ReasonedLoss& x, const ReasonedLoss& y) {
        return x.points != y.points ? x.points > y.points : x.id < y.id;
    });
    return losses;
}

std::size_t nearestRow(const Rows& rows, double t_s) {
    const auto row = std::lower_bound(rows.begin(), rows.end(), t_s - 1e-9,
                                      [](const CourseRow& r, double t) { return r.t_s < t; });
    if (row == rows.end()) return rows.empty() ? 0 : rows.size() - 1;
    return std::size_t(row - rows.begin());
}

// The needle never entered the body, and no step was done: every value is that of an idle trainee.
bool reachedNothing(const LoadedAttempt& a) {
    return a.result()->steps.done.empty() && !findEntry(a);
}

double end_s(const LoadedAttempt& a) {
    if (!a.course.empty()) return a.course.back().t_s;
    return a.result() ? double(a.result()->ticks) * a.stored.info.dt_s : 0.0;
}

}  // namespace

std::optional<training::Score> findScore(const records::AttemptResult& result) {
    if (result.score_version != std::uint64_t(training::kScoreVersion)) return {};
    const training::Course course = courseFromGoal(result);
    training::MetricValues values{};
    bool has_case = true;
    for (std::size_t i = 0; i < training::kMetricCount; ++i) {
        if (!training::isMetricOf(course, training::metricTable()[i])) continue;
        const auto row =
            std::find_if(result.metrics.begin(), result.metrics.end(),
                         [&](const records::MetricRow& m) { return m.id == training::metricTable()[i].id; });
        if (row != result.metrics.end())
            values[i] = row->value;
        else if (training::MetricId(i) == training::MetricId::caseReview)
            has_case = false;  // recorded before there were cases, and scored again
        else
            return {};
    }
    return training::computeScore(values, stepsDone(result), course, has_case);
}

std::vector<Advice> makeAdvice(const LoadedAttempt& a) {
    std::vector<Advice> all;
    if (!a.result() || reachedNothing(a)) return all;
    for (const ReasonedLoss& loss : findReasons(*a.result())) {
        if (all.size() == kMaxAdvice) break;
        const auto hint =
            std::find_if(kHints.begin(), kHints.end(), [&](const Hint& h) { return h.id == loss.id; });
        const bool known = hint != kHints.end();
        const When found = known && hint->find ? hint->find(a) : When();
        Advice advice;
        advice.t_s = std::min(found.value_or(end_s(a)), end_s(a));
        advice.row = nearestRow(a.course, advice.t_s);
        const std::string what = known ? hint->text : "Improve this metric";
        const bool steps = loss.id == metric(MetricId::procedure).id;
        advice.text = steps ? fmt::format("{}: {}. {:.1f} of {:.3g} points were lost.", what, loss.why,
                                          loss.points, loss.of)
                            : fmt::format("{}: {}, {}. {:.1f} of {:.3g} points were lost.", what, loss.name,
                                          loss.why, loss.points, loss.of);
        all.push_back(std::move(advice));
    }
    return all;
}

Table momentTable(const LoadedAttempt& a, const std::vector<Advice>& all) {
    Table table{
        "The record at the moments of the advice",
        {"Advice", "Time [s]", "Tool", "Tissue at the tip", "Depth [mm]", "Axial force [N]", "Breath"},
        {},
        {true, true, false, false, true, true, false}};
    for (std::size_t i = 0; i < all.size(); ++i) {
        std::vector<std::string> cells{std::to_string(i + 1), fixed(all[i].t_s, 2)};
        if (all[i].row < a.course.size()) {
            const CourseRow& row = a.course[all[i].row];
            cells.emplace_back(haptics::kToolNames[std::size_t(row.tool)]);
            cells.push_back(row.in_body ? std::string(patient::tissueName(row.tissue)) : "–");
            cells.push_back(row.in_body ? fixed(kMmPerM * row.depth_m, 1) : "–");
            cells.push_back(row.in_body ? fixed(row.force_n, 2) : "–");
            cells.emplace_back(row.breath_held ? "held" : "free");
        }
        cells.resize(table.head.size(), "–");
        table.rows.push_back(std::move(cells));
        table.row_ids.push_back("moment-" + std::to_string(i + 1));
    }
    return table;
}

void markMoments(Figure& timeline, const std::vector<Advice>& all, std::size_t first) {
    for (std::size_t i = 0; i < all.size(); ++i)
        timeline.marks.push_back(
            {all[i].t_s, double(timeline.y.names.size() - 1), "advice " + std::to_string(first + i)});
}

std::optional<DescribedFigure> momentFigure(const LoadedAttempt& a, const Advice& advice,
                                            std::size_t number) {
    const std::string mark = "advice " + std::to_string(number);
    if (advice.row < a.course.size() && a.course[advice.row].in_body) {
        const CourseRow& row = a.course[advice.row];
        DescribedFigure f = forceFigure(a, {});
        f.figure.low = true;
        f.figure.marks = {{kMmPerM * row.depth_m, row.force_n, mark}};
        f.description += " The moment: " + fixed(kMmPerM * row.depth_m, 1) + " mm.";
        f.caption = "The force over depth, with the moment.";
        return f;
    }
    const double from_s = std::max(0.0, advice.t_s - kAround_s);
    const double to_s = std::min(advice.t_s + kAround_s, std::max(end_s(a), advice.t_s));
    LoadedAttempt part;
    part.stored = a.stored, part.input_only = a.input_only;
    std::copy_if(a.course.begin(), a.course.end(), std::back_inserter(part.course),
                 [&](const CourseRow& row) { return row.t_s >= from_s && row.t_s <= to_s; });
    std::erase_if(part.stored.events, [&](const records::EventRow& event) {
        const double t_s = double(event.tick) * a.stored.info.dt_s;
        return t_s < from_s || t_s > to_s;
    });
    DescribedFigure f = timelineFigure(part);
    if (!showsMoreThanTools(f.figure)) return std::nullopt;
    f.figure.x.min = from_s, f.figure.x.max = std::max(to_s, from_s + 1.0);
    markMoments(f.figure, {advice}, number);
    f.description = "Timeline around " + fixed(advice.t_s, 1) + " s.";
    f.caption = "The timeline around the moment.";
    return f;
}

}  // namespace stylet::report
