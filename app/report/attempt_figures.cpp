#include "app/report/attempt_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <span>
#include <tuple>

#include "app/report/bands.h"
#include "base/text.h"

namespace stylet::report {

using patient::Tissue;

namespace {

constexpr std::size_t kBuckets = 700;   // per curve: one or two pixels each
constexpr std::size_t kMaxSpans = 300;  // per lane
constexpr double kTableStep_mm = 5.0;
constexpr const char* kSentForce = "Force sent to the device";
constexpr Colour kGrey{0.55, 0.58, 0.62};
constexpr double kLead_m = 0.010;  // the reference path starts this far before its entry, in air

// Force over depth for the rows from `begin` to `end`. Uses only rows in the body, with a gap wherever the
// needle left it.
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
std::size_t insertionBegin(const std::vector<CourseRow>& rows, std::size_t row, double tick_s) {
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
    Table table{"force at every " + fixed(kTableStep_mm, 0) + " mm of depth", {"Depth [mm]"}, {}, {true}};
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

// Calls `visit` for each run of rows with equal `key`. If there are too many runs, leaves out the shortest
// and returns true.
template <typename Key, typename Visit>
bool forEachRun(const std::vector<CourseRow>& rows, double tick_s, const Key& key, const Visit& visit) {
    if (rows.empty()) return false;
    const double all_s = rows.back().t_s - rows.front().t_s;
    double min_s = 0.0;
    for (int attempt = 0; attempt < 2; ++attempt) {
        std::size_t count = 0;
        for (std::size_t i = 0, j = 0; i < rows.size(); i = j) {
            for (j = i + 1; j < rows.size() && key(rows[j]) == key(rows[i]) &&
                            rows[j].t_s - rows[j - 1].t_s < 2.5 * tick_s;)
                ++j;
            const double to_s = rows[j - 1].t_s + tick_s;
            if (to_s - rows[i].t_s < min_s) continue;
            ++count;
            if (attempt == 1) visit(rows[i], rows[i].t_s, to_s);
        }
        if (count > kMaxSpans) min_s = all_s / double(kMaxSpans);
    }
    return min_s > 0.0;
}

enum Lane { laneTool, laneBreath, laneTissue, laneFaults, laneSteps, laneRisk, laneContact, laneNotes };
const std::vector<std::string> kLanes{"tool",        "breath", "tissue",  "faults",
                                      "steps, cuts", "risk",   "contact", "notes"};

constexpr std::array<Colour, haptics::kToolCount> kToolColours{{{0.99, 0.90, 0.70},
                                                                {0.78, 0.89, 0.97},
                                                                {0.97, 0.80, 0.70},
                                                                {0.86, 0.82, 0.94},
                                                                {0.76, 0.91, 0.84},
                                                                {0.90, 0.88, 0.62},
                                                                {0.80, 0.80, 0.80},
                                                                {0.70, 0.86, 0.92}}};
constexpr Colour kHeldColour{0.76, 0.91, 0.84}, kFaultColour{0.95, 0.65, 0.55};

std::string_view toolName(const CourseRow& row) {
    return haptics::kToolNames[std::size_t(row.tool)];
}

struct EventStyle {
    const char* kind;
    const char* name;
    Lane lane;
    Colour colour;
    const char* shape;
};
constexpr std::array<EventStyle, 15> kEventStyles{
    {{"step", "step done", laneSteps, kGreen, "circle"},
     {"cut", "cut", laneSteps, kBlack, "rectRot"},
     {"moment", "moment", laneNotes, kBlue, "rect"},
     {"risk", "risk structure struck", laneRisk, kVermilion, "triangle"},
     {"near_miss", "close pass", laneRisk, kOrange, "rect"},
     {"contact", "contact", laneContact, kBlue, "circle"},
     {"tool", "tool taken", laneTool, kBlack, "rect"},
     {"breath", "breath", laneBreath, kBlue, "rect"},
     {"fault", "fault", laneFaults, kVermilion, "crossRot"},
     {"bookmark", "bookmark", laneNotes, kBlue, "rectRot"},
     {"comment", "comment", laneNotes, kPurple, "circle"},
     {"answer", "answer about the case", laneNotes, kGreen, "rect"},
     {"injected", "event injected", laneNotes, kVermilion, "triangle"},
     {"pause", "pause", laneNotes, kBlack, "rect"},
     {"", "other", laneNotes, kBlack, "circle"}}};

const EventStyle& eventStyle(const std::string& kind) {
    for (const EventStyle& style : kEventStyles)
        if (kind == style.kind) return style;
    return kEventStyles.back();
}

// Empty for an attempt that was cut short.
std::span<const records::PunctureRow> listPunctures(const LoadedAttempt& a) {
    return a.result() ? std::span(a.result()->punctures) : std::span<const records::PunctureRow>();
}

double timelineEnd_s(const LoadedAttempt& a) {
    double end_s = a.course.empty() ? 0.0 : a.course.back().t_s;
    if (a.stored.result) end_s = std::max(end_s, double(a.stored.result->ticks) * a.stored.info.dt_s);
    for (const records::EventRow& event : a.stored.events)
        end_s = std::max(end_s, double(event.tick) * a.stored.info.dt_s);
    return std::max(end_s, 1.0);
}

FigureChoice timeSeries(const LoadedAttempt& a, const std::string& name, const std::string& axis,
                        Colour colour, double (*value)(const CourseRow&)) {
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
    series.points = downsample(points, kBuckets);
    series.width = 1.5;
    return {name, {axis}, {series}};
}

bool hasPoints(const FigureChoice& choice) {
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

std::optional<std::size_t> keyRow(const LoadedAttempt& a) {
    if (a.result() && a.result()->target_hit)
        for (auto p = a.result()->punctures.rbegin(); p != a.result()->punctures.rend(); ++p) {
            if (p->tissue != "duct" || p->kind != "cut") continue;
            const double t_s = double(p->tick) * a.stored.info.dt_s;
            const auto row =
                std::lower_bound(a.course.begin(), a.course.end(), t_s - 0.5 * a.stored.info.dt_s,
                                 [](const CourseRow& r, double t) { return r.t_s < t; });
            if (row != a.course.end()) return std::size_t(row - a.course.begin());
        }
    return deepestRow(a.course);
}

// The needle's depth counts from the surface of the skin, but a planned path begins at the centre of a skin
// voxel. So the path is extended backwards into the air, and depth counts from where it enters the skin.
ReferenceCurve exactCurve(const patient::Patient& patient, const patient::PlannedPath& path,
                          const haptics::NeedleSettings& needle) {
    const Vec3 path_m = path.target_reference_m - path.entry_reference_m;
    ReferenceCurve curve{"reference path, exact", {}};
    if (glm::length(path_m) == 0.0) return curve;
    const patient::TissueMap map(patient);
    haptics::ExactSolver solver(map, needle);
    const Vec3 before_m = path.entry_reference_m - kLead_m * glm::normalize(path_m);
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

ReferenceCurve insertionCurve(const LoadedAttempt& expert) {
    const std::optional<std::size_t> deepest = deepestRow(expert.course);
    ReferenceCurve curve{"attempt " + expert.stored.id, {}};
    const double tick_s = expert.stored.info.dt_s;
    if (deepest)
        curve.points = downsample(
            forcePoints(expert.course, insertionBegin(expert.course, *deepest, tick_s), *deepest + 1, tick_s),
            kBuckets);
    return curve;
}

DescribedFigure forceFigure(const LoadedAttempt& a, const std::vector<ReferenceCurve>& references) {
    DescribedFigure f;
    const std::optional<std::size_t> deepest = deepestRow(a.course);
    const double tick_s = a.stored.info.dt_s;
    f.figure.x = {"depth of the tip along the track [mm]", 0.0};
    f.figure.y = {"axial force [N], positive resists insertion"};
    double deepest_mm = 0.0, peak_n = 0.0, peak_mm = 0.0;
    const std::size_t begin = deepest ? insertionBegin(a.course, *deepest, tick_s) : 0;
    FigureSeries earlier{"earlier tries", kGrey};
    earlier.points = downsample(forcePoints(a.course, 0, begin, tick_s), kBuckets);
    earlier.width = 1.0;
    if (deepest) {
        deepest_mm = kMmPerM * a.course[*deepest].depth_m;
        for (const CourseRow& row : a.course)
            if (row.in_body && row.force_n > peak_n) peak_n = row.force_n, peak_mm = kMmPerM * row.depth_m;
        std::vector<CourseRow> inside;
        for (std::size_t i = begin; i <= *deepest; ++i)
            if (a.course[i].in_body) inside.push_back(a.course[i]);
        for (const TissueBand& band : tissueBands(inside, inside.size()))
            f.figure.bands.push_back({kMmPerM * band.from_m, kMmPerM * band.to_m,
                                      std::string(patient::tissueName(band.tissue)),
                                      bandColour(band.tissue)});
        FigureSeries in{"way in", kVermilion}, out{"way out", kBlue};
        in.points = downsample(forcePoints(a.course, begin, *deepest + 1, tick_s), kBuckets);
        out.points = downsample(forcePoints(a.course, *deepest, a.course.size(), tick_s), kBuckets);
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
    for (const records::PunctureRow& p : listPunctures(a))
        if (p.kind == "cut" && double(p.tick) * tick_s >= from_s)
            f.figure.marks.push_back({kMmPerM * (p.border_depth_m + p.tenting_m), p.force_before_n,
                                      p.label + " " + fixed(p.force_before_n, 2) + " N"});
    f.data = forceTable(f.figure.series, deepest_mm);
    if (deepest)
        f.description = "Force over depth. The needle came " +
                        fixed(kMmPerM * a.course[*deepest].depth_m, 1) +
                        " mm deep; the largest resistance was " + fixed(peak_n, 2) + " N at " +
                        fixed(peak_mm, 1) + " mm.";
    else
        f.description = "Force over depth: the needle did not enter the body.";
    for (const FigurePoint& mark : f.figure.marks)
        f.description += " Cut at " + fixed(mark.x, 1) + " mm: " + mark.text + ".";
    f.caption = deepest ? "The axial force on the needle. Bands: the tissue at the tip. Marks: the cuts, "
                          "each with the force just before it."
                        : "The needle did not enter the body.";
    if (!earlier.points.empty())
        f.caption += " The needle was in the body before: grey, without tissues and marks.";
    if (!references.empty()) f.caption += " Dashed: the force along the reference.";
    return f;
}

Table eventTable(const LoadedAttempt& a) {
    Table table{"What happened, in order", {"Time [s]", "Kind", "What"}, {}, {true, false, false}, true};
    for (const records::EventRow& event : a.stored.events)
        table.rows.push_back({fixed(double(event.tick) * a.stored.info.dt_s, 2),
                              event.kind == "near_miss" ? "close pass" : event.kind, event.text});
    return table;
}

Table caseTable(const LoadedAttempt& a) {
    Table table{
        "Review of the case", {"Question", "Answer", "Right or wrong, and why"}, {}, {false, false, false}};
    for (const records::EventRow& event : a.stored.events) {
        if (event.kind != "answer") continue;
        // "Must the clotting be corrected? No: wrong, the INR of 2.4 is above 1.8 (SIR 2019)"
        const std::size_t asked = std::min(event.text.find('?'), event.text.size() - 1) + 1,
                          said = std::min(event.text.find(": ", asked), event.text.size());
        table.rows.push_back({event.text.substr(0, asked),
                              std::string(trimmed(event.text.substr(asked, said - asked))),
                              event.text.substr(std::min(said + 2, event.text.size()))});
    }
    return table;
}

Table punctureTable(const LoadedAttempt& a) {
    Table table{"Borders that the needle met",
                {"Into", "Tissue", "How", "Time [s]", "Depth of the border [mm]", "Pushed ahead [mm]",
                 "Force before [N]", "Force after [N]"},
                {},
                {false, false, false, true, true, true, true, true}};
    for (const records::PunctureRow& p : listPunctures(a))
        table.rows.push_back({p.label, p.tissue, p.kind, fixed(double(p.tick) * a.stored.info.dt_s, 2),
                              fixed(kMmPerM * p.border_depth_m, 1), fixed(kMmPerM * p.tenting_m, 1),
                              fixed(p.force_before_n, 2), fixed(p.force_after_n, 2)});
    return table;
}

DescribedFigure timelineFigure(const LoadedAttempt& a) {
    DescribedFigure f;
    const double tick_s = a.stored.info.dt_s, end_s = timelineEnd_s(a);
    f.figure.x = {"time [s]", 0.0, end_s};
    f.figure.y.names = kLanes;
    f.data = {"the intervals of the timeline",
              {"What", "From [s]", "To [s]", "Which"},
              {},
              {false, true, true, false}};
    std::size_t held = 0, inside = 0;  // in ticks, including those of spans that are left out
    std::set<haptics::Tool> seen;
    std::string tools;
    for (const CourseRow& row : a.course) {
        held += row.breath_held, inside += row.in_body;
        if (seen.insert(row.tool).second) tools += (tools.empty() ? "" : ", ") + std::string(toolName(row));
    }
    bool left_out = false;
    // Adds a span for each run of rows with the same text. Rows with an empty text get no span.
    const auto addSpans = [&](Lane lane, std::string_view (*text)(const CourseRow&),
                              Colour (*colour)(const CourseRow&)) {
        left_out |= forEachRun(a.course, tick_s, text, [&](const CourseRow& row, double from_s, double to_s) {
            const std::string shown(text(row));
            if (shown.empty()) return;
            f.figure.spans.push_back({lane, from_s, to_s, shown, colour(row)});
            f.data.rows.push_back({kLanes[lane], fixed(from_s, 2), fixed(to_s, 2), shown});
        });
    };
    addSpans(laneTool, toolName, [](const CourseRow& r) { return kToolColours[std::size_t(r.tool)]; });
    addSpans(
        laneBreath, [](const CourseRow& r) { return std::string_view(r.breath_held ? "held" : ""); },
        [](const CourseRow&) { return kHeldColour; });
    addSpans(
        laneTissue, [](const CourseRow& r) { return r.in_body ? patient::tissueName(r.tissue) : ""; },
        [](const CourseRow& r) { return bandColour(r.tissue); });
    addSpans(
        laneFaults,
        a.input_only ? [](const CourseRow& r) { return std::string_view(r.faults != 0 ? "not tracked" : ""); }
                     : [](const CourseRow& r) { return std::string_view(r.faults != 0 ? "no force" : ""); },
        [](const CourseRow&) { return kFaultColour; });
    for (const records::EventRow& event : a.stored.events) {
        const EventStyle& style = eventStyle(event.kind);
        auto series = std::find_if(f.figure.series.begin(), f.figure.series.end(),
                                   [&](const FigureSeries& s) { return s.name == style.name; });
        if (series == f.figure.series.end()) {
            f.figure.series.push_back({style.name, style.colour});
            series = f.figure.series.end() - 1;
            series->line = false, series->shape = style.shape;
        }
        const double t_s = double(event.tick) * tick_s;
        series->points.push_back({t_s, double(style.lane), event.text + " (" + fixed(t_s, 2) + " s)"});
    }
    f.description = "Timeline of " + fixed(end_s, 1) + " s. " +
                    (tools.empty() ? "" : "Tools in hand: " + tools + ". ") +
                    "The needle was in the body for " + fixed(double(inside) * tick_s, 1) +
                    " s; the breath was held for " + fixed(double(held) * tick_s, 1) + " s.";
    f.caption = "Bars: time intervals. Points: events.";
    if (left_out) f.caption += " Intervals too short to see are left out.";
    return f;
}

bool showsMoreThanTools(const Figure& timeline) {
    return std::ranges::any_of(timeline.spans, [](const FigureSpan& s) { return s.lane != laneTool; }) ||
           std::ranges::any_of(timeline.series, [](const FigureSeries& s) {
               return std::ranges::any_of(s.points,
                                          [](const FigurePoint& p) { return p.y != double(laneTool); });
           });
}

DescribedFigure courseFigure(const LoadedAttempt& a) {
    DescribedFigure f;
    f.figure.x = {"time [s]", 0.0, timelineEnd_s(a)};
    f.figure.low = true;
    std::vector<FigureChoice> all{
        timeSeries(a, "Depth of the tip", "depth [mm]", kBlue,
                   [](const CourseRow& r) { return r.in_body ? kMmPerM * r.depth_m : kGap; }),
        timeSeries(a, "Axial force of the model", "force [N]", kVermilion,
                   [](const CourseRow& r) { return r.in_body ? r.force_n : kGap; }),
        timeSeries(a, kSentForce, "force [N]", kGreen, [](const CourseRow& r) { return r.sent_n; }),
        timeSeries(
            a, "Clearance to the nearest risk structure", "clearance [mm]", kPurple,
            [](const CourseRow& r) { return std::isfinite(r.clearance_m) ? kMmPerM * r.clearance_m : kGap; }),
        timeSeries(a, "Breath", "signal v, 1: full inspiration", kBlue,
                   [](const CourseRow& r) { return r.breath_v; })};
    if (a.input_only) std::erase_if(all, [](const FigureChoice& c) { return c.name == kSentForce; });
    f.data = {"lowest and highest value of each", {"What", "Lowest", "Highest"}, {}, {false, true, true}};
    for (FigureChoice& choice : all) {
        if (!hasPoints(choice)) continue;
        double low = INFINITY, high = -INFINITY;
        for (const FigurePoint& p : choice.series[0].points)
            if (!std::isnan(p.y)) low = std::min(low, p.y), high = std::max(high, p.y);
        f.data.rows.push_back({choice.name + ", " + choice.y.title, fixed(low, 2), fixed(high, 2)});
        f.description += (f.description.empty() ? "" : "; ") + choice.name + " from " + fixed(low, 2) +
                         " to " + fixed(high, 2);
        f.figure.choices.push_back(std::move(choice));
    }
    forEachRun(
        a.course, a.stored.info.dt_s, [](const CourseRow& r) { return r.breath_held; },
        [&](const CourseRow& row, double from_s, double to_s) {
            if (row.breath_held) f.figure.bands.push_back({from_s, to_s, "breath held", kHeldColour});
        });
    f.description = "Over time, one at a time: " + f.description + ".";
    f.caption = "One quantity over time; select it above. Green: the breath was held.";
    return f;
}

}  // namespace stylet::report
