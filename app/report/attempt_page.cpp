#include "app/report/attempt_page.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/report/advice.h"
#include "app/report/glossary.h"
#include "app/report/slices.h"
#include "app/report/verdict.h"
#include "app/training/learning.h"
#include "app/training/score.h"
#include "base/hex.h"
#include "base/statistics.h"
#include "base/text.h"
#include "patient/package/verdict.h"

namespace stylet::report {

using records::AttemptState;
using records::StoredAttempt;

namespace {

constexpr int kStillWidth = 560;
constexpr std::size_t kTrailPoints = 1500, kCourseRows = 4000, kLongList = 25;

// Percentiles of fewer attempts are meaningless.
constexpr std::size_t kLeastCohort = 4;

std::string explainState(const StoredAttempt& a) {
    if (records::isUnfinishedExam(a))
        return "cut short: it ends where its writer was stopped; it counts as an exam that was not passed";
    if (a.state == AttemptState::cut_short) return "cut short: it ends where its writer was stopped";
    if (a.state == AttemptState::running) return "still running";
    if (!records::countsInStatistics(a))
        return std::string(records::stateText(a)) + ": it enters no statistics";
    return "done";
}

// `check`: as in RecordInfo. Empty for a patient that the check accepted, and for a reference patient.
std::string explainCheck(const std::string& check) {
    if (check.empty()) return "";
    return check == patient::kNotChecked ? "This patient was never checked by stylet-model check."
                                         : "The check of this patient was " + check + ".";
}

double seconds(const LoadedAttempt& a) {
    const double dt_s = a.stored.info.dt_s;
    if (a.result()) return double(a.result()->ticks) * dt_s;
    return a.course.empty() ? 0.0 : a.course.back().t_s;
}

std::optional<double> findValue(const LoadedAttempt& a, std::string_view id) {
    if (a.result())
        for (const records::MetricRow& m : a.result()->metrics)
            if (m.id == id) return m.value;
    return {};
}

// What the needle struck, and how often: ": blood vessel 12, bone 6". Empty if it struck nothing.
std::string listStruck(const LoadedAttempt& a) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kStructures{
        {{"vessel_hits", "blood vessel"},
         {"bone_hits", "bone"},
         {"lung_hits", "lung or gas"},
         {"organ_hits", "other organ"}}};
    std::vector<std::string> struck;
    for (const auto& [id, name] : kStructures)
        if (const double hits = findValue(a, id).value_or(0.0); hits > 0.0)
            struck.push_back(fmt::format("{} {:.0f}", name, hits));
    return struck.empty() ? "" : fmt::format(": {}", fmt::join(struck, ", "));
}

std::vector<Headline> makeHeadlines(const LoadedAttempt& a) {
    std::vector<Headline> all;
    if (a.result()) {
        all.push_back({fixed(a.result()->total, 1) + " of 100", "score"});
        all.push_back({a.result()->target_hit ? "Yes" : "No", "bile duct hit"});
        if (a.record.difficulty == "exam" && records::countsInStatistics(a.stored))
            all.push_back({passed(a.stored) ? "Passed" : "Failed", "exam"});
    }
    if (records::isUnfinishedExam(a.stored)) all.push_back({"Not passed", "exam, cut short"});
    all.push_back({clockText(seconds(a)), "minutes and seconds"});
    // The metrics' own values, so that no other number with the same meaning stands beside them.
    double peak_n = a.result() ? a.result()->peak_force_n : 0.0;
    for (const CourseRow& row : a.course)
        if (row.in_body) peak_n = std::max(peak_n, std::fabs(row.force_n));
    all.push_back({fixed(findValue(a, "peak_force").value_or(peak_n), 2) + " N", "largest axial force"});
    std::size_t risk = 0, close = 0;
    for (const records::EventRow& event : a.stored.events)
        risk += event.kind == "risk", close += event.kind == "near_miss";
    if (!a.stored.events.empty()) {
        all.push_back({fixed(findValue(a, "no_go_touches").value_or(double(risk)), 0),
                       "no-go areas touched" + listStruck(a)});
        all.push_back({std::to_string(close), "close passes that touched nothing"});
    }
    return all;
}

std::vector<Fact> makeFacts(const LoadedAttempt& a) {
    const records::AttemptInfo& info = a.stored.info;
    std::vector<Fact> facts;
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) facts.push_back({name, value});
    };
    add("Trainee (pseudonym)", info.trainee);
    add("Attempt", a.stored.id);
    add("Begun", dateText(a.stored.started_utc));
    add("State", explainState(a.stored));
    if (a.result()) add("Score table", "version " + std::to_string(a.result()->score_version));
    add("Patient", info.patient);
    add("Scenario", info.scenario);
    add("Difficulty", info.difficulty);
    if (a.result()) add("Missing for an exam", fmt::format("{}", fmt::join(missingParts(*a.result()), "; ")));
    add("Critical errors", fmt::format("{}", fmt::join(criticalErrors(a.stored), "; ")));
    const std::string &needle = a.record.needle, &title = a.needle_title;
    add("Needle", needle.empty() || title.empty() ? needle + title : needle + " (" + title + ")");
    add("Device", info.device + (a.record.clock.empty() ? "" : " (" + a.record.clock + ")"));
    add("Seed", std::to_string(info.seed));
    add("Program", info.program_version.empty() ? "" : "stylet " + info.program_version);
    add("Force gain of the device", a.input_only ? "" : fixed(info.device_gain, 3));
    add("Registration error", info.registration_rms_m
                                  ? fixed(kMmPerM * *info.registration_rms_m, 2) + " mm (root mean square)"
                                  : "");
    const patient::PlannedPath& path = a.record.path;
    add("Reference path", fixed(kMmPerM * path.length_m, 1) + " mm, quality " + fixed(path.quality, 2));
    if (a.result()) {
        const records::AttemptResult& r = *a.result();
        add("X-rays", fixed(r.dose.fluoroscopy_s, 1) + " s, " + fixed(1e3 * r.dose.air_kerma_gy, 2) +
                          " mGy at the reference point");
        add("Contrast medium", fixed(r.dose.contrast_ml, 1) + " ml");
        if (r.dose.anaesthetic_ml > 0.0)
            add("Local anaesthetic", fixed(r.dose.anaesthetic_ml, 1) + " ml of lidocaine 1 %");
        add("Cut sideways", fixed(kMmPerM * r.lateral_cut_m, 1) + " mm");
        add("Faults", r.haptics.fault_names);
        add("Ticks", std::to_string(r.haptics.ticks) + ", " + std::to_string(r.haptics.late_ticks) + " late");
    }
    if (a.record.end) add("State hash", hexText(a.record.end->state_hash));
    return facts;
}

// A page is the same wherever the attempt's folder is, so it names files relative to that folder.
std::string relativeToAttempt(std::string text, const std::filesystem::path& folder) {
    const std::string prefix = (folder / "").string();
    for (std::size_t at = 0; (at = text.find(prefix, at)) != text.npos;)
        text.erase(at, prefix.size());
    return text;
}

std::vector<Vec3> needleTrail(const LoadedAttempt& a) {
    std::vector<Vec3> trail;
    std::size_t inside = 0;
    for (const CourseRow& row : a.course)
        inside += row.in_body;
    const std::size_t step = inside / kTrailPoints + 1;
    std::size_t i = 0;
    for (const CourseRow& row : a.course)
        if (row.in_body && i++ % step == 0) trail.push_back(row.tip_m);
    return trail;
}

// Slices at the given row, with the needle and its track.
Picture slicePicture(const LoadedAttempt& a, const CourseRow& row, const patient::Patient& patient,
                     const std::string& title) {
    NeedlePicture needle;
    needle.tip_m = row.tip_m;
    needle.axis = row.axis;
    needle.depth_m = row.depth_m;
    needle.breath = {row.breath_v, 0.0};
    needle.target_m = a.record.path.target_m;
    needle.trail_m = needleTrail(a);
    needle.reference_m = {a.record.path.entry_m, a.record.path.target_m};
    needle.title = title;
    needle.caption = "tip " + fixed(kMmPerM * row.depth_m, 1) + " mm deep, " + fixed(row.t_s, 2) +
                     " s, breath " + (row.breath_held ? "held" : "free");
    const SliceSheet sheet = sliceSheet(patient, needle);
    Picture picture{sheet.png, "image/png", sheet.width, sheet.height, "", ""};
    picture.alt =
        "Three slices through the CT: two along the needle, near axial and near coronal, one across it at "
        "the tip, with the needle, the track of its tip and the reference path; " +
        needle.caption + ".";
    picture.caption =
        "The needle in the patient on three slices, with the track of its tip and the reference path.";
    return picture;
}

void addSlices(Page& page, const LoadedAttempt& a, const AttemptContext& context) {
    page.section("Needle in the patient");
    const std::optional<std::size_t> row = keyRow(a);
    if (row && context.patient) {
        const bool hit = a.result() && a.result()->target_hit;
        page.picture(
            slicePicture(a, a.course[*row], *context.patient,
                         hit ? "The puncture of the bile duct" : "The deepest point: no target was hit"));
    } else {
        page.paragraph(row ? "The patient of this attempt was not found, so there are no slices."
                           : "The needle did not enter the body.");
    }
}

// The extremes of one quantity over some rows, as table cells. Empty if no value is known.
class Extremes {
  public:
    void add(double value) {
        if (!std::isfinite(value)) return;
        low_ = std::min(low_, value), high_ = std::max(high_, value);
    }
    std::string low(int digits) const { return low_ > high_ ? "" : fixed(low_, digits); }
    std::string high(int digits) const { return low_ > high_ ? "" : fixed(high_, digits); }

  private:
    double low_ = INFINITY, high_ = -INFINITY;
};

// Each row summarises several ticks: the values at the first tick, and the extremes over all of them.
Table courseTable(const LoadedAttempt& a) {
    Table table;
    table.head = {"time_s",      "ticks",        "tool",         "depth_mm",
                  "force_n",     "sent_n",       "breath_v",     "breath_held",
                  "tissue",      "clearance_mm", "depth_min_mm", "depth_max_mm",
                  "force_min_n", "force_max_n",  "sent_max_n",   "clearance_min_mm"};
    table.number.assign(table.head.size(), true);
    table.number[2] = table.number[8] = false;
    const auto csv = [](double value, int digits) {
        return std::isfinite(value) ? fixed(value, digits) : std::string();
    };
    const std::size_t step = a.course.size() / kCourseRows + 1;
    for (std::size_t i = 0; i < a.course.size(); i += step) {
        const std::size_t end = std::min(i + step, a.course.size());
        Extremes depth_mm, force_n, sent_n, clearance_mm;
        for (std::size_t k = i; k < end; ++k) {
            const CourseRow& r = a.course[k];
            if (r.in_body) depth_mm.add(kMmPerM * r.depth_m), force_n.add(r.force_n);
            sent_n.add(r.sent_n), clearance_mm.add(kMmPerM * r.clearance_m);
        }
        const CourseRow& r = a.course[i];
        table.rows.push_back(
            {fixed(r.t_s, 5), std::to_string(end - i), std::string(haptics::kToolNames[std::size_t(r.tool)]),
             r.in_body ? fixed(kMmPerM * r.depth_m, 3) : "", r.in_body ? fixed(r.force_n, 4) : "",
             csv(r.sent_n, 4), csv(r.breath_v, 4), r.breath_held ? "1" : "0",
             r.in_body ? std::string(patient::tissueName(r.tissue)) : "", csv(kMmPerM * r.clearance_m, 2),
             depth_mm.low(3), depth_mm.high(3), force_n.low(4), force_n.high(4), sent_n.high(4),
             clearance_mm.low(2)});
    }
    return table;
}

// Collapses tables that are too long to scroll past.
void addList(Page& page, const Table& table) {
    if (table.rows.size() > kLongList)
        page.collapsibleTable(table);
    else if (!table.rows.empty())
        page.table(table);
}

// Explains the metrics that this program version knows; a record may contain others.
Table meaningTable(const records::AttemptResult& result) {
    Table table{"What each metric means; its source as in metrics.md and model.md of the user's guide",
                {"Metric", "What", "Best", "Worst", "Source"},
                {},
                {false, false, true, true, false}};
    for (const training::Metric& metric : training::metricTable())
        if (std::any_of(result.metrics.begin(), result.metrics.end(),
                        [&](const records::MetricRow& row) { return row.id == metric.id; }))
            table.rows.push_back({std::string(metric.name), std::string(metric.what), metricText(metric.best),
                                  metricText(metric.worst), std::string(metric.source)});
    return table;
}

// Score first, then what to do about the largest losses, each with its moment and, if it shows anything, a
// picture of it.
void addAdvice(Page& page, const LoadedAttempt& a, const AttemptContext& context,
               const std::vector<Advice>& all) {
    page.section("Advice");
    if (!a.result()) return page.paragraph("An attempt that did not end has no score and no advice.");
    if (!records::countsInStatistics(a.stored))
        page.paragraph(
            fmt::format("This attempt was {}. It is compared with no other, and enters no statistics.",
                        records::stateText(a.stored)));
    if (all.empty())
        page.paragraph(a.result()->steps.done.empty() && !deepestRow(a.course)
                           ? "No step was done and the needle did not enter the body, so there is no advice."
                           : "No metric lost half a point or more.");
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Advice& advice = all[i];
        page.advice(i + 1, advice.text, "In the record at " + clockText(advice.t_s),
                    "moment-" + std::to_string(i + 1));
        const bool in_body = advice.row < a.course.size() && a.course[advice.row].in_body;
        if (in_body && context.patient)
            page.picture(
                slicePicture(a, a.course[advice.row], *context.patient, "Advice " + std::to_string(i + 1)));
        else if (const std::optional<DescribedFigure> figure = momentFigure(a, advice, i + 1))
            page.figure(*figure);
    }
}

// Which score table was used, and why points are missing.
void explainScore(Page& page, const records::AttemptResult& result) {
    const auto today = std::uint64_t(training::kScoreVersion);
    page.paragraph(
        result.score_version == today
            ? fmt::format("Scored with version {} of the score table.", today)
            : fmt::format("Scored with version {} of the score table; today's is version {}. \"stylet replay "
                          "ATTEMPT --fast\" scores the attempt again and shows both.",
                          result.score_version, today));
    const std::optional<training::Score> score = findScore(result);
    if (!score) return;
    double by_steps = 0.0;
    for (const training::MetricLoss& loss : training::splitLosses(*score))
        by_steps += loss.by_steps;
    if (by_steps >= 0.05)
        page.paragraph(fmt::format(
            "Of the missing points, {:.1f} are missing because {}. In the table: \"steps\".", by_steps,
            training::describeMissingSteps(result.steps.done.size(), std::size_t(result.steps.of))));
}

// What a row of the metric table lost points by.
std::vector<std::string> lossReasons(const records::AttemptResult& result) {
    std::vector<std::string> reasons(result.metrics.size());
    const std::optional<training::Score> score = findScore(result);
    if (!score) return reasons;
    const auto split = training::splitLosses(*score);
    for (std::size_t i = 0; i < result.metrics.size(); ++i)
        for (std::size_t m = 0; m < split.size(); ++m) {
            if (training::metricTable()[m].id != result.metrics[i].id) continue;
            const bool value = split[m].by_value >= 0.005, steps = split[m].by_steps >= 0.005;
            reasons[i] = value && steps ? "value, steps" : value ? "value" : steps ? "steps" : "";
        }
    return reasons;
}

void addScore(Page& page, const LoadedAttempt& a, const AttemptContext& context, AttemptReport& report) {
    page.section("Score");
    if (!a.stored.result || a.stored.result->metrics.empty()) {
        page.paragraph(a.stored.state == AttemptState::done ? "This attempt was not scored."
                                                            : "An attempt that did not end has no score.");
        return;
    }
    explainScore(page, *a.stored.result);
    // An attempt that enters no statistics is compared with no other.
    const std::vector<StoredAttempt> cohort =
        records::countsInStatistics(a.stored) ? context.cohort : std::vector<StoredAttempt>();
    report.metrics = metricTable(*a.stored.result, cohort);
    const auto others = std::size_t(std::count_if(cohort.begin(), cohort.end(), records::countsInStatistics));
    page.paragraph(
        others >= kLeastCohort
            ? fmt::format("Each metric earns points up to its weight. The cohort: {} finished attempts at "
                          "the same scenario in these records, this one among them. A percentile is the "
                          "share of the cohort that earned fewer points; of those that earned as many, half "
                          "are counted, itself included.",
                          others)
            : fmt::format("Each metric earns points up to its weight. Fewer than {} finished attempts at "
                          "this scenario are in these records, so there is no cohort to compare with.",
                          kLeastCohort));
    page.table(report.metrics);
    if (const Table meanings = meaningTable(*a.stored.result); !meanings.rows.empty())
        page.collapsibleTable(meanings);
}

}  // namespace

std::string dateText(const std::string& utc) {
    if (utc.size() < 16 || utc[10] != 'T') return utc;
    return utc.substr(0, 10) + " " + utc.substr(11, 5) + " UTC";
}

std::string metricName(const records::MetricRow& metric) {
    return metric.id == "near_misses" ? metric.name + ", graded, with hits" : metric.name;
}

std::string metricText(double value) {
    if (!std::isfinite(value)) return fixed(value, 0);
    const double size = std::fabs(value);
    return fixed(value, size == std::floor(size) ? 0 : size < 0.1 ? 4 : size < 10.0 ? 2 : 1);
}

Table metricTable(const records::AttemptResult& result, const std::vector<StoredAttempt>& cohort) {
    Table table{"Metrics, their points and the cohort",
                {"Metric", "Value", "Unit", "Points", "Of", "Lost by", "Cohort's median value",
                 "Percentile by points"},
                {},
                {false, true, false, true, true, false, true, true},
                true};
    const std::vector<std::string> reasons = lossReasons(result);
    const auto row = [&](const std::string& name, const std::string& value, const std::string& unit,
                         double points, double most, const std::string& reason,
                         const std::vector<double>& values, const std::vector<double>& all_points) {
        const bool enough = all_points.size() >= kLeastCohort;
        table.rows.push_back(
            {name, value, unit, fixed(points, 2), fixed(most, 2), reason,
             enough && !values.empty() ? metricText(median(values)) : "–",
             enough ? fixed(100.0 * training::percentileRank(all_points, points).value_or(kGap), 0) : "–"});
    };
    for (std::size_t i = 0; i < result.metrics.size(); ++i) {
        const records::MetricRow& m = result.metrics[i];
        std::vector<double> values, points;
        for (const StoredAttempt& other : cohort)
            if (records::countsInStatistics(other))
                for (const records::MetricRow& o : other.result->metrics)
                    if (o.id == m.id) values.push_back(o.value), points.push_back(o.points);
        row(metricName(m), metricText(m.value), m.unit, m.points, m.max_points, reasons[i], values, points);
    }
    std::vector<double> totals;
    for (const StoredAttempt& other : cohort)
        if (records::countsInStatistics(other)) totals.push_back(other.result->total);
    row("Total", fixed(result.total, 1), "", result.total, 100.0, "", totals, totals);
    return table;
}

AttemptReport attemptReport(const LoadedAttempt& a, const AttemptContext& context) {
    AttemptReport report;
    const records::AttemptInfo& info = a.stored.info;
    Page page(info.trainee.empty() ? "Attempt " + a.stored.id : "Attempt of " + info.trainee,
              (info.scenario.empty() ? "" : "Scenario " + info.scenario + " on ") + info.patient +
                  (a.stored.started_utc.empty() ? "" : ", " + dateText(a.stored.started_utc)) +
                  (records::countsInStatistics(a.stored) ? "" : ". State: " + explainState(a.stored)) + ".");
    page.headlines(makeHeadlines(a));
    if (const std::string check = explainCheck(a.record.patient_check); !check.empty()) page.paragraph(check);
    const std::vector<Advice> advice = makeAdvice(a);
    addAdvice(page, a, context, advice);

    std::vector<ReferenceCurve> references = context.references;
    if (context.patient && references.empty())
        references.push_back(exactCurve(*context.patient, a.record.path, a.needle));
    page.section("Force over depth");
    page.figure(forceFigure(a, references));
    addList(page, punctureTable(a));

    addSlices(page, a, context);

    page.section("Timeline");
    DescribedFigure timeline = timelineFigure(a);
    markMoments(timeline.figure, advice);
    page.figure(timeline);
    if (!advice.empty()) page.table(momentTable(a, advice));
    if (const DescribedFigure course = courseFigure(a); !course.figure.choices.empty()) page.figure(course);
    report.events = eventTable(a);
    addList(page, report.events);
    report.course = courseTable(a);

    if (const Table review = caseTable(a); !review.rows.empty()) {
        page.section("Case");
        page.table(review);
    }
    addScore(page, a, context, report);

    const Stills stills = loadStills(a.stored.folder, context.max_stills, kStillWidth);
    if (!stills.pictures.empty()) {
        page.section("Stills");
        if (stills.left_out > 0)
            page.paragraph("The first " + std::to_string(stills.pictures.size()) + " by name; " +
                           std::to_string(stills.left_out) + " more lie in the attempt's folder.");
        page.stills(stills.pictures);
    }
    page.section("Facts");
    page.facts(makeFacts(a));
    std::vector<std::string> warnings = a.warnings;
    warnings.insert(warnings.end(), stills.warnings.begin(), stills.warnings.end());
    if (!warnings.empty()) {
        page.section("What could not be read");
        for (const std::string& warning : warnings)
            page.paragraph(relativeToAttempt(warning, a.stored.folder));
    }
    addGlossary(page);
    report.html = page.html();
    return report;
}

}  // namespace stylet::report
