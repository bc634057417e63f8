#include "app/report/attempt_page.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/report/slices.h"
#include "app/training/learning.h"
#include "app/training/score.h"
#include "base/hex.h"
#include "base/statistics.h"
#include "base/text.h"

namespace stylet::report {

using records::AttemptState;
using records::StoredAttempt;

namespace {

constexpr int kStillWidth = 560;
constexpr std::size_t kTrailPoints = 1500, kCourseRows = 4000, kLongList = 25;

// Percentiles of fewer attempts are meaningless.
constexpr std::size_t kLeastCohort = 4;

// In the order of AttemptState.
constexpr std::array<std::string_view, 3> kStateTexts{"still running", "done",
                                                      "cut short: it ends where its writer was stopped"};

std::string stateText(AttemptState state) {
    return std::string(enumName(kStateTexts, state));
}

double seconds(const LoadedAttempt& a) {
    const double dt_s = a.stored.info.dt_s;
    if (a.result()) return double(a.result()->ticks) * dt_s;
    return a.course.empty() ? 0.0 : a.course.back().t_s;
}

std::vector<Headline> makeHeadlines(const LoadedAttempt& a) {
    std::vector<Headline> all;
    if (a.result()) {
        all.push_back({fixed(a.result()->total, 1) + " of 100", "score"});
        all.push_back({a.result()->target_hit ? "Yes" : "No", "bile duct hit"});
    }
    all.push_back({clockText(seconds(a)), "minutes and seconds"});
    double peak_n = a.result() ? a.result()->peak_force_n : 0.0;
    for (const CourseRow& row : a.course)
        peak_n = std::max(peak_n, row.force_n);
    all.push_back({fixed(peak_n, 2) + " N", "largest axial force"});
    std::size_t risk = 0, near = 0;
    for (const records::EventRow& event : a.stored.events)
        risk += event.kind == "risk", near += event.kind == "near_miss";
    if (!a.stored.events.empty()) {
        all.push_back({std::to_string(risk), "risk structures struck"});
        all.push_back({std::to_string(near), "near misses"});
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
    add("State", stateText(a.stored.state));
    add("Patient", info.patient);
    add("Scenario", info.scenario);
    add("Difficulty", info.difficulty);
    const std::string &needle = a.record.needle, &title = a.needle_title;
    add("Needle", needle.empty() || title.empty() ? needle + title : needle + " (" + title + ")");
    add("Device", info.device + (a.record.clock.empty() ? "" : " (" + a.record.clock + ")"));
    add("Seed", std::to_string(info.seed));
    add("Program", info.program_version.empty() ? "" : "stylet " + info.program_version);
    add("Force gain of the device", fixed(info.device_gain, 3));
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
Picture slicePicture(const LoadedAttempt& a, const CourseRow& row, const patient::Patient& patient) {
    NeedlePicture needle;
    needle.tip_m = row.tip_m;
    needle.axis = row.axis;
    needle.depth_m = row.depth_m;
    needle.breath = {row.breath_v, 0.0};
    needle.target_m = a.record.path.target_m;
    needle.trail_m = needleTrail(a);
    needle.reference_m = {a.record.path.entry_m, a.record.path.target_m};
    needle.title = a.result() && a.result()->target_hit ? "The puncture of the bile duct"
                                                        : "The deepest point: no target was hit";
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
        page.picture(slicePicture(a, a.course[*row], *context.patient));
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

void addScore(Page& page, const LoadedAttempt& a, const AttemptContext& context, AttemptReport& report) {
    page.section("Score");
    if (!a.stored.result || a.stored.result->metrics.empty()) {
        page.paragraph(a.stored.state == AttemptState::done ? "This attempt was not scored."
                                                            : "An attempt that did not end has no score.");
        return;
    }
    report.metrics = metricTable(*a.stored.result, context.cohort);
    std::size_t others = 0;
    for (const StoredAttempt& other : context.cohort)
        others += other.result.has_value();
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

std::string metricText(double value) {
    if (!std::isfinite(value)) return fixed(value, 0);
    const double size = std::fabs(value);
    return fixed(value, size == std::floor(size) ? 0 : size < 0.1 ? 4 : size < 10.0 ? 2 : 1);
}

Table metricTable(const records::AttemptResult& result, const std::vector<StoredAttempt>& cohort) {
    Table table{"Metrics, their points and the cohort",
                {"Metric", "Value", "Unit", "Points", "Of", "Cohort's median value", "Percentile by points"},
                {},
                {false, true, false, true, true, true, true},
                true};
    const auto row = [&](const std::string& name, const std::string& value, const std::string& unit,
                         double points, double most, const std::vector<double>& values,
                         const std::vector<double>& all_points) {
        const bool enough = all_points.size() >= kLeastCohort;
        table.rows.push_back(
            {name, value, unit, fixed(points, 2), fixed(most, 1),
             enough && !values.empty() ? metricText(median(values)) : "–",
             enough ? fixed(100.0 * training::percentileRank(all_points, points).value_or(kGap), 0) : "–"});
    };
    for (const records::MetricRow& m : result.metrics) {
        std::vector<double> values, points;
        for (const StoredAttempt& other : cohort)
            if (other.result)
                for (const records::MetricRow& o : other.result->metrics)
                    if (o.id == m.id) values.push_back(o.value), points.push_back(o.points);
        row(m.name, metricText(m.value), m.unit, m.points, m.max_points, values, points);
    }
    std::vector<double> totals;
    for (const StoredAttempt& other : cohort)
        if (other.result) totals.push_back(other.result->total);
    row("Total", fixed(result.total, 1), "", result.total, 100.0, totals, totals);
    return table;
}

AttemptReport attemptReport(const LoadedAttempt& a, const AttemptContext& context) {
    AttemptReport report;
    const records::AttemptInfo& info = a.stored.info;
    Page page(info.trainee.empty() ? "Attempt " + a.stored.id : "Attempt of " + info.trainee,
              (info.scenario.empty() ? "" : "Scenario " + info.scenario + " on ") + info.patient +
                  (a.stored.started_utc.empty() ? "" : ", " + dateText(a.stored.started_utc)) +
                  (a.stored.state == AttemptState::done ? "" : ". State: " + stateText(a.stored.state)) +
                  ".");
    page.headlines(makeHeadlines(a));

    std::vector<ReferenceCurve> references = context.references;
    if (context.patient && references.empty())
        references.push_back(exactCurve(*context.patient, a.record.path, a.needle));
    page.section("Force over depth");
    page.figure(forceFigure(a, references));
    addList(page, punctureTable(a));

    addSlices(page, a, context);

    page.section("Timeline");
    page.figure(timelineFigure(a));
    if (const DescribedFigure course = courseFigure(a); !course.figure.choices.empty()) page.figure(course);
    report.events = eventTable(a);
    addList(page, report.events);
    report.course = courseTable(a);

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
    report.html = page.html();
    return report;
}

}  // namespace stylet::report
