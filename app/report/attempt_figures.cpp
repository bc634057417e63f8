#include "app/report/attempt_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <tuple>

#include "app/report/bands.h"

namespace stylet::report {

using patient::Tissue;

namespace {

constexpr std::size_t kBuckets = 700;    // per curve: one or two pixels each
constexpr std::size_t kMostSpans = 300;  // per lane
constexpr double kTableStep_mm = 5.0;
constexpr Colour kGrey{0.55, 0.58, 0.62};
constexpr double kLead_m = 0.010;  // the reference path starts this far before its entry, in air

// The points of a range of rows inside the body, with a gap wherever the needle left the body.
std::vector<FigurePoint> forcePoints(const std::vector<CourseRow>& rows, std::size_t begin, std::size_t end,
                                     double tick_s) {
    std::vector<FigurePoint> points;
    double last_s = -1.0;
    for (std::size_t i = begin; i < end; ++i) {
        if (!rows[i].in_body) continue;
        if (last_s >= 0.0 && rows[i].t_s - last_s > 2.5 * tick_s)
            points.push_back({kMmPerM * rows[i].depth_m, kGap});
        points.push_back({kMmPerM * rows[i].depth_m, rows[i].force_n});
        last_s = rows[i].t_s;
    }
    return points;
}

// The first row of the uninterrupted stay in the body that contains `row`.
std::size_t beginOfStay(const std::vector<CourseRow>& rows, std::size_t row, double tick_s) {
    while (row > 0 && rows[row - 1].in_body && rows[row].t_s - rows[row - 1].t_s < 2.5 * tick_s)
        --row;
    return row;
}

double valueAt(const std::vector<FigurePoint>& points, double x) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const double a = points[i].x, b = points[i + 1].x;
        if (x < std::min(a, b) || x > std::max(a, b) || std::isnan(points[i].y) ||
            std::isnan(points[i + 1].y))
            continue;
        return a == b ? points[i].y : points[i].y + (x - a) / (b - a) * (points[i + 1].y - points[i].y);
    }
    return kGap;
}

Table forceTable(const std::vector<FigureSeries>& series, double deepest_mm) {
    Table table;
    table.caption = "force at every " + fixed(kTableStep_mm, 0) + " mm of depth";
    table.head = {"Depth [mm]"};
    table.number = {true};
    for (const FigureSeries& s : series)
        table.head.push_back(s.name + " [N]"), table.number.push_back(true);
    for (double depth_mm = 0.0; depth_mm <= deepest_mm && table.rows.size() < 100;
         depth_mm += kTableStep_mm) {
        table.rows.push_back({fixed(depth_mm, 0)});
        for (const FigureSeries& s : series)
            table.rows.back().push_back(fixed(valueAt(s.points, depth_mm), 2));
    }
    return table;
}

// Calls `take` for each run of rows with equal `key`. If there are too many runs, leaves out the shortest
// and returns true.
template <typename Key, typename Take>
bool eachStretch(const std::vector<CourseRow>& rows, double tick_s, const Key& key, const Take& take) {
    if (rows.empty()) return false;
    const double all_s = rows.back().t_s - rows.front().t_s;
    double least_s = 0.0;
    for (int attempt = 0; attempt < 2; ++attempt) {
        std::size_t count = 0;
        for (std::size_t i = 0, j = 0; i < rows.size(); i = j) {
            for (j = i + 1; j < rows.size() && key(rows[j]) == key(rows[i]) &&
                            rows[j].t_s - rows[j - 1].t_s < 2.5 * tick_s;)
                ++j;
            const double to_s = rows[j - 1].t_s + tick_s;
            if (to_s - rows[i].t_s < least_s) continue;
            ++count;
            if (attempt == 1) take(rows[i], rows[i].t_s, to_s);
        }
        if (count > kMostSpans) least_s = all_s / double(kMostSpans);
    }
    return least_s > 0.0;
}

enum Lane { laneTool, laneBreath, laneTissue, laneFaults, laneSteps, laneRisk, laneContact, laneNotes };
const std::vector<std::string> kLanes{"tool",        "breath", "tissue",  "faults",
                                      "steps, cuts", "risk",   "contact", "notes"};

constexpr std::array<Colour, haptics::kToolCount> kToolColours{
    {{0.99, 0.90, 0.70}, {0.78, 0.89, 0.97}, {0.97, 0.80, 0.70}, {0.86, 0.82, 0.94}, {0.76, 0.91, 0.84}}};
constexpr Colour kHeldColour{0.76, 0.91, 0.84}, kFaultColour{0.95, 0.65, 0.55};

struct EventLook {
    const char* kind;
    const char* name;
    Lane lane;
    Colour colour;
    const char* shape;
};
constexpr std::array<EventLook, 14> kEventLooks{
    {{"step", "step done", laneSteps, kGreen, "circle"},
     {"cut", "cut", laneSteps, kBlack, "rectRot"},
     {"moment", "moment", laneNotes, kBlue, "rect"},
     {"risk", "risk structure struck", laneRisk, kVermilion, "triangle"},
     {"near_miss", "near miss", laneRisk, kOrange, "rect"},
     {"contact", "contact", laneContact, kBlue, "circle"},
     {"tool", "tool taken", laneTool, kBlack, "rect"},
     {"breath", "breath", laneBreath, kBlue, "rect"},
     {"fault", "fault", laneFaults, kVermilion, "crossRot"},
     {"bookmark", "bookmark", laneNotes, kBlue, "rectRot"},
     {"comment", "comment", laneNotes, kPurple, "circle"},
     {"injected", "event injected", laneNotes, kVermilion, "triangle"},
     {"pause", "pause", laneNotes, kBlack, "rect"},
     {"", "other", laneNotes, kBlack, "circle"}}};

const EventLook& lookOf(const std::string& kind) {
    for (const EventLook& look : kEventLooks)
        if (kind == look.kind) return look;
    return kEventLooks.back();
}

double endOf(const AttemptFiles& a) {
    double end_s = a.course.empty() ? 0.0 : a.course.back().t_s;
    if (a.stored.result) end_s = std::max(end_s, double(a.stored.result->ticks) * a.stored.info.dt_s);
    end_s = std::max(end_s, double(a.summary.ticks) * a.stored.info.dt_s);
    for (const records::EventRow& event : a.stored.events)
        end_s = std::max(end_s, double(event.tick) * a.stored.info.dt_s);
    return std::max(end_s, 1.0);
}

FigureChoice overTime(const AttemptFiles& a, const std::string& name, const std::string& axis, Colour colour,
                      double (*value)(const CourseRow&)) {
    std::vector<FigurePoint> points;
    points.reserve(a.course.size());
    double last_s = -1.0;
    bool gap = true;
    for (const CourseRow& row : a.course) {
        const double y = value(row);
        const bool skipped = last_s >= 0.0 && row.t_s - last_s > 2.5 * a.stored.info.dt_s;
        if ((std::isnan(y) || skipped) && !gap) points.push_back({row.t_s, kGap}), gap = true;
        if (!std::isnan(y)) points.push_back({row.t_s, y}), gap = false;
        last_s = row.t_s;
    }
    FigureSeries series{name, colour};
    series.points = thinned(points, kBuckets);
    series.width = 1.5;
    return {name, {axis}, {series}};
}

bool anyPoint(const FigureChoice& choice) {
    return std::any_of(choice.series[0].points.begin(), choice.series[0].points.end(),
                       [](const FigurePoint& p) { return !std::isnan(p.y); });
}

}  // namespace

std::optional<std::size_t> deepestRow(const std::vector<CourseRow>& rows) {
    std::optional<std::size_t> deepest;
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (rows[i].in_body && (!deepest || rows[i].depth_m > rows[*deepest].depth_m)) deepest = i;
    return deepest;
}

std::optional<std::size_t> tellingRow(const AttemptFiles& a) {
    if (a.summary.target_hit)
        for (auto p = a.summary.punctures.rbegin(); p != a.summary.punctures.rend(); ++p) {
            if (p->tissue != "duct" || p->kind != "cut") continue;
            const double t_s = double(p->tick) * a.stored.info.dt_s;
            const auto row =
                std::lower_bound(a.course.begin(), a.course.end(), t_s - 0.5 * a.stored.info.dt_s,
                                 [](const CourseRow& r, double t) { return r.t_s < t; });
            if (row != a.course.end()) return std::size_t(row - a.course.begin());
        }
    return deepestRow(a.course);
}

// A path begins at the centre of a skin voxel, but depth counts from the skin's surface, as for the needle.
// Therefore the path is followed from the air.
ReferenceCurve exactCurve(const patient::Patient& patient, const patient::PlannedPath& path) {
    const Vec3 way_m = path.target_reference_m - path.entry_reference_m;
    ReferenceCurve curve{"reference path, exact", {}};
    if (glm::length(way_m) == 0.0) return curve;
    const patient::TissueMap map(patient);
    haptics::ExactSolver solver(map, haptics::NeedleSettings{});
    const Vec3 before_m = path.entry_reference_m - kLead_m * glm::normalize(way_m);
    const haptics::ExactForce& force = solver.solve(before_m, path.target_reference_m);
    if (force.events.empty()) return curve;
    const double skin_m = force.events.front().border_depth_m;
    for (const haptics::ForcePiece& piece : force.pieces) {
        const double from_m = std::max(piece.begin_m, skin_m), length_m = piece.end_m - from_m;
        if (length_m <= 0.0) continue;
        const int parts = piece.c2_n_per_m2 == 0.0 ? 1 : std::clamp(int(length_m / 0.0002), 2, 400);
        for (int i = 0; i <= parts; ++i) {
            const double depth_m = from_m + length_m * i / parts, x = depth_m - piece.begin_m;
            curve.points.push_back(
                {kMmPerM * (depth_m - skin_m), piece.c0_n + x * (piece.c1_n_per_m + x * piece.c2_n_per_m2)});
        }
    }
    return curve;
}

ReferenceCurve curveOf(const AttemptFiles& expert) {
    const std::optional<std::size_t> deepest = deepestRow(expert.course);
    ReferenceCurve curve{"attempt " + expert.stored.id, {}};
    const double tick_s = expert.stored.info.dt_s;
    if (deepest)
        curve.points = thinned(
            forcePoints(expert.course, beginOfStay(expert.course, *deepest, tick_s), *deepest + 1, tick_s),
            kBuckets);
    return curve;
}

DescribedFigure forceFigure(const AttemptFiles& a, const std::vector<ReferenceCurve>& references) {
    DescribedFigure f;
    const std::optional<std::size_t> deepest = deepestRow(a.course);
    const double tick_s = a.stored.info.dt_s;
    f.figure.x = {"depth of the tip along the track [mm]", 0.0};
    f.figure.y = {"axial force [N], positive resists insertion"};
    double deepest_mm = 0.0, peak_n = 0.0, peak_mm = 0.0;
    const std::size_t begin = deepest ? beginOfStay(a.course, *deepest, tick_s) : 0;
    FigureSeries earlier{"earlier tries", kGrey};
    earlier.points = thinned(forcePoints(a.course, 0, begin, tick_s), kBuckets);
    earlier.width = 1.0;
    if (deepest) {
        deepest_mm = kMmPerM * a.course[*deepest].depth_m;
        for (const CourseRow& row : a.course)
            if (row.in_body && row.force_n > peak_n) peak_n = row.force_n, peak_mm = kMmPerM * row.depth_m;
        for (const TissueBand& band : [&] {
                 std::vector<CourseRow> in;
                 for (std::size_t i = begin; i <= *deepest; ++i)
                     if (a.course[i].in_body) in.push_back(a.course[i]);
                 return tissueBands(in, in.size());
             }())
            f.figure.bands.push_back({kMmPerM * band.from_m, kMmPerM * band.to_m,
                                      std::string(patient::tissueName(band.tissue)),
                                      bandColour(band.tissue)});
        FigureSeries in{"way in", kVermilion}, out{"way out", kBlue};
        in.points = thinned(forcePoints(a.course, begin, *deepest + 1, tick_s), kBuckets);
        out.points = thinned(forcePoints(a.course, *deepest, a.course.size(), tick_s), kBuckets);
        in.width = 2.5, out.width = 1.5, out.dash = {2, 2};
        f.figure.series = {in, out};
    }
    static const std::array<Colour, 2> colours{kBlack, kGreen};
    for (std::size_t i = 0; i < references.size(); ++i) {
        FigureSeries reference{references[i].name, colours[i % colours.size()]};
        reference.points = references[i].points;
        reference.width = 1.8, reference.dash = {8, 4};
        f.figure.series.push_back(reference);
        if (!reference.points.empty()) deepest_mm = std::max(deepest_mm, reference.points.back().x);
    }
    if (!earlier.points.empty()) f.figure.series.push_back(earlier);
    const double from_s = deepest ? a.course[begin].t_s - tick_s : 0.0;
    for (const PunctureRow& p : a.summary.punctures)
        if (p.kind == "cut" && double(p.tick) * tick_s >= from_s)
            f.figure.marks.push_back({kMmPerM * (p.border_depth_m + p.tenting_m), p.force_before_n,
                                      p.label + " " + fixed(p.force_before_n, 2) + " N"});
    f.data = forceTable(f.figure.series, deepest_mm);
    if (deepest)
        f.description = "Force over depth. The needle came " +
                        fixed(kMmPerM * a.course[*deepest].depth_m, 1) + " mm deep; the largest force was " +
                        fixed(peak_n, 2) + " N at " + fixed(peak_mm, 1) + " mm.";
    else
        f.description = "Force over depth: the needle did not enter the body.";
    for (const FigurePoint& mark : f.figure.marks)
        f.description += " Cut at " + fixed(mark.x, 1) + " mm: " + mark.text + ".";
    f.caption =
        deepest
            ? "The axial force on the needle. Behind it the tissues that the tip went through, and marked "
              "the cuts with the force just before each."
            : "The needle did not enter the body.";
    if (!earlier.points.empty())
        f.caption += " The needle was in the body before: grey, without tissues and marks.";
    if (!references.empty()) f.caption += " Dashed: what it is along the reference.";
    return f;
}

std::vector<records::EventRow> eventsOf(const AttemptFiles& a) {
    if (!a.stored.events.empty()) return a.stored.events;
    std::vector<records::EventRow> events;
    for (const MomentRow& moment : a.summary.moments)
        events.push_back({moment.tick, "moment", moment.name});
    for (const PunctureRow& p : a.summary.punctures)
        if (p.kind == "cut")
            events.push_back({p.tick, "cut", p.label + " at " + fixed(p.force_before_n, 2) + " N"});
    std::sort(events.begin(), events.end(), [](const records::EventRow& x, const records::EventRow& y) {
        return std::tie(x.tick, x.kind, x.text) < std::tie(y.tick, y.kind, y.text);
    });
    return events;
}

Table eventTable(const AttemptFiles& a) {
    Table table;
    table.caption = "What happened, in order";
    table.head = {"Time [s]", "Kind", "What"};
    table.number = {true, false, false};
    table.sortable = true;
    for (const records::EventRow& event : eventsOf(a))
        table.rows.push_back({fixed(double(event.tick) * a.stored.info.dt_s, 2),
                              event.kind == "near_miss" ? "near miss" : event.kind, event.text});
    return table;
}

Table punctureTable(const AttemptFiles& a) {
    Table table;
    table.caption = "Borders that the needle met";
    table.head = {"Into",
                  "Tissue",
                  "How",
                  "Time [s]",
                  "Depth of the border [mm]",
                  "Pushed ahead [mm]",
                  "Force before [N]",
                  "Force after [N]"};
    table.number = {false, false, false, true, true, true, true, true};
    for (const PunctureRow& p : a.summary.punctures)
        table.rows.push_back({p.label, p.tissue, p.kind, fixed(double(p.tick) * a.stored.info.dt_s, 2),
                              fixed(kMmPerM * p.border_depth_m, 1), fixed(kMmPerM * p.tenting_m, 1),
                              fixed(p.force_before_n, 2), fixed(p.force_after_n, 2)});
    return table;
}

DescribedFigure timelineFigure(const AttemptFiles& a) {
    DescribedFigure f;
    const double tick_s = a.stored.info.dt_s, end_s = endOf(a);
    f.figure.x = {"time [s]", 0.0, end_s};
    f.figure.y.names = kLanes;
    f.data.caption = "the stretches of the timeline";
    f.data.head = {"What", "From [s]", "To [s]", "Which"};
    f.data.number = {false, true, true, false};
    std::size_t held = 0, inside = 0;  // in ticks, including stretches that are left out
    std::set<haptics::Tool> seen;
    std::string tools;
    for (const CourseRow& row : a.course) {
        held += row.breath_held, inside += row.in_body;
        if (a.sampled && seen.insert(row.tool).second)
            tools += (tools.empty() ? "" : ", ") + std::string(haptics::kToolNames[std::size_t(row.tool)]);
    }
    bool left_out = false;
    const auto span = [&](Lane lane, double from_s, double to_s, const std::string& text, Colour colour) {
        f.figure.spans.push_back({lane, from_s, to_s, text, colour});
        f.data.rows.push_back({kLanes[lane], fixed(from_s, 2), fixed(to_s, 2), text});
    };
    if (a.sampled)
        left_out |= eachStretch(
            a.course, tick_s, [](const CourseRow& r) { return r.tool; },
            [&](const CourseRow& row, double from_s, double to_s) {
                span(laneTool, from_s, to_s, std::string(haptics::kToolNames[std::size_t(row.tool)]),
                     kToolColours[std::size_t(row.tool)]);
            });
    left_out |= eachStretch(
        a.course, tick_s, [](const CourseRow& r) { return r.breath_held; },
        [&](const CourseRow& row, double from_s, double to_s) {
            if (!row.breath_held) return;
            span(laneBreath, from_s, to_s, "held", kHeldColour);
        });
    left_out |= eachStretch(
        a.course, tick_s, [](const CourseRow& r) { return r.in_body ? int(r.tissue) : -1; },
        [&](const CourseRow& row, double from_s, double to_s) {
            if (!row.in_body) return;
            span(laneTissue, from_s, to_s, std::string(patient::tissueName(row.tissue)),
                 bandColour(row.tissue));
        });
    left_out |= eachStretch(
        a.course, tick_s, [](const CourseRow& r) { return r.faults != 0; },
        [&](const CourseRow& row, double from_s, double to_s) {
            if (row.faults != 0) span(laneFaults, from_s, to_s, "no force", kFaultColour);
        });
    for (const records::EventRow& event : eventsOf(a)) {
        const EventLook& look = lookOf(event.kind);
        auto series = std::find_if(f.figure.series.begin(), f.figure.series.end(),
                                   [&](const FigureSeries& s) { return s.name == look.name; });
        if (series == f.figure.series.end()) {
            f.figure.series.push_back({look.name, look.colour});
            series = f.figure.series.end() - 1;
            series->line = false, series->shape = look.shape;
        }
        const double t_s = double(event.tick) * tick_s;
        series->points.push_back({t_s, double(look.lane), event.text + " (" + fixed(t_s, 2) + " s)"});
    }
    f.description = "Timeline of " + fixed(end_s, 1) + " s. " +
                    (tools.empty() ? "" : "Tools in hand: " + tools + ". ") +
                    "The needle was in the body for " + fixed(double(inside) * tick_s, 1) +
                    " s; the breath was held for " + fixed(double(held) * tick_s, 1) +
                    (a.sampled ? " s." : " s of the time in the body.");
    f.caption =
        a.sampled
            ? "Stretches of time and, as points, what happened in them."
            : "Stretches while the needle was in the body (no samples of the other ticks are kept here) "
              "and, as points, what happened.";
    if (left_out) f.caption += " Stretches too short to see are left out.";
    return f;
}

DescribedFigure courseFigure(const AttemptFiles& a) {
    DescribedFigure f;
    f.figure.x = {"time [s]", 0.0, endOf(a)};
    f.figure.low = true;
    std::vector<FigureChoice> all{
        overTime(a, "Depth of the tip", "depth [mm]", kBlue,
                 [](const CourseRow& r) { return r.in_body ? kMmPerM * r.depth_m : kGap; }),
        overTime(a, "Axial force of the model", "force [N]", kVermilion,
                 [](const CourseRow& r) { return r.in_body ? r.force_n : kGap; }),
        overTime(a, "Force sent to the device", "force [N]", kGreen,
                 [](const CourseRow& r) { return r.sent_n; }),
        overTime(
            a, "Clearance to the nearest risk structure", "clearance [mm]", kPurple,
            [](const CourseRow& r) { return std::isfinite(r.clearance_m) ? kMmPerM * r.clearance_m : kGap; }),
        overTime(a, "Breath", "signal v, 1: full inspiration", kBlue,
                 [](const CourseRow& r) { return r.breath_v; })};
    f.data.caption = "lowest and highest value of each";
    f.data.head = {"What", "Lowest", "Highest"};
    f.data.number = {false, true, true};
    for (FigureChoice& choice : all) {
        if (!anyPoint(choice)) continue;
        double low = INFINITY, high = -INFINITY;
        for (const FigurePoint& p : choice.series[0].points)
            if (!std::isnan(p.y)) low = std::min(low, p.y), high = std::max(high, p.y);
        f.data.rows.push_back({choice.name + ", " + choice.y.title, fixed(low, 2), fixed(high, 2)});
        f.description += (f.description.empty() ? "" : "; ") + choice.name + " from " + fixed(low, 2) +
                         " to " + fixed(high, 2);
        f.figure.choices.push_back(std::move(choice));
    }
    eachStretch(
        a.course, a.stored.info.dt_s, [](const CourseRow& r) { return r.breath_held; },
        [&](const CourseRow& row, double from_s, double to_s) {
            if (row.breath_held) f.figure.bands.push_back({from_s, to_s, "breath held", kHeldColour});
        });
    f.description = "Over time, one at a time: " + f.description + ".";
    f.caption = "One quantity over time, as chosen. Green behind it: the breath was held.";
    return f;
}

}  // namespace stylet::report
