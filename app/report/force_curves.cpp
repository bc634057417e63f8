#include "app/report/force_curves.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/report/bands.h"
#include "app/report/chart.h"

namespace stylet::report {

using haptics::Tissue;

namespace {

constexpr double kStep_m = 0.00001;  // 10 mm/s at 1 kHz
constexpr double kLead_m = 0.008, kThickness_m = 0.012, kIn_m = 0.006, kPitch_m = 0.001;
constexpr Colour kInsertionColour{0.75, 0.16, 0.14}, kWithdrawalColour{0.20, 0.38, 0.62},
    kBound{0.75, 0.16, 0.14, 0.35};

constexpr std::array<std::pair<Tissue, Tissue>, 8> kPairs{{{Tissue::air, Tissue::skin},
                                                           {Tissue::skin, Tissue::soft},
                                                           {Tissue::soft, Tissue::bone},
                                                           {Tissue::soft, Tissue::cartilage},
                                                           {Tissue::soft, Tissue::fascia},
                                                           {Tissue::fascia, Tissue::liver},
                                                           {Tissue::liver, Tissue::vessel},
                                                           {Tissue::liver, Tissue::duct}}};

// A package of two layers: `before` for kLead_m, then `tissue`. Each voxel has a label.
patient::Package makeLayers(const patient::TissueTable& table, Tissue before, Tissue tissue) {
    patient::Package package;
    package.tissues = table;
    for (int t = 1; t < patient::kTissueCount; ++t) {
        patient::Label label;
        label.id = std::uint8_t(t);
        label.tissue = Tissue(t);
        package.label_table.push_back(label);
    }
    const int lead = int(std::lround(kLead_m / kPitch_m));
    const Grid grid{{lead + int(std::lround(kThickness_m / kPitch_m)), 1, 1},
                    {kPitch_m, 0.1, 0.1},
                    {0.5 * kPitch_m - kLead_m, 0.0, 0.0}};
    package.ct = CtVolume(grid, std::int16_t(-1000));
    package.labels = LabelVolume(grid);
    for (int i = 0; i < grid.dims.x; ++i)
        package.labels[{i, 0, 0}] = std::uint8_t(i < lead ? before : tissue);
    return package;
}

std::vector<DepthForce> exactInsertion(const patient::TissueTable& table, Tissue before, Tissue tissue,
                                       haptics::NeedleSettings settings, double a1_share) {
    settings.a1_share = a1_share;
    const std::vector<haptics::Segment> path{
        {0.0, Tissue::air, 0}, {0.001, before, 0}, {0.001 + kLead_m, tissue, 0}};
    const haptics::ExactForce exact =
        haptics::solveExact(table, path, 0.001 + kLead_m + kThickness_m, settings);
    std::vector<DepthForce> way;
    for (double d = -0.002; d <= kIn_m; d += kStep_m)
        way.push_back({d, exact.at(0.001 + kLead_m + d)});
    return way;
}

TissueCurve computeTissueCurve(const patient::TissueTable& table, const haptics::NeedleSettings& settings,
                               Tissue before, Tissue tissue) {
    const patient::Package package = makeLayers(table, before, tissue);
    const patient::Patient patient(package);
    TissueCurve curve{before, tissue, {}, {}, {}, {}, false, {}};
    haptics::NeedleState needle;
    haptics::NeedleEvents events;
    const auto to = [&](double x_m, std::vector<DepthForce>& way) {
        haptics::stepNeedle(needle, settings, {patient, {}}, {{x_m, 0.0, 0.0}, {1.0, 0.0, 0.0}}, events);
        way.push_back({x_m, needle.force_n});
        for (int i = 0; i < events.count; ++i) {
            const haptics::NeedleEvent& e = events.list[std::size_t(i)];
            if (e.kind != haptics::NeedleEventKind::puncture || e.border.to != tissue) continue;
            curve.cut = true;
            curve.cut_at = {e.tenting_m, e.force_before_n};
        }
    };
    const int steps = int(std::lround((kLead_m + 0.001 + kIn_m) / kStep_m));
    for (int i = 0; i <= steps; ++i)
        to(-kLead_m - 0.001 + i * kStep_m, curve.in);
    for (int i = steps - 1; i >= int(std::lround((kLead_m - 0.001) / kStep_m)); --i)
        to(-kLead_m - 0.001 + i * kStep_m, curve.out);
    curve.min_a1 = exactInsertion(table, before, tissue, settings, 0.0);
    curve.max_a1 = exactInsertion(table, before, tissue, settings, 1.0);
    return curve;
}

std::vector<Point> inMillimetres(const std::vector<DepthForce>& way) {
    std::vector<Point> points;
    for (const DepthForce& d : way)
        points.push_back({d.depth_m * 1000.0, d.force_n});
    return points;
}

// An entry of a legend: a line and, on the baseline `at`, its text.
void drawEntry(Canvas& canvas, Point at, Colour colour, double width, const std::string& text) {
    canvas.line({at.x, at.y - 5.0}, {at.x + 34.0, at.y - 5.0}, width, colour);
    canvas.text({at.x + 44.0, at.y}, text, {14, kInk});
}

void drawTissue(Canvas& canvas, const Box& box, const TissueCurve& c, const patient::TissueRow& row) {
    const bool steep = std::isinf(row.cut_force_n);
    Panel panel(canvas, box, {-2.0, kIn_m * 1000.0, 2.0},
                steep ? Range{-4.0, 18.0, 2.0} : Range{-2.0, 4.5, 0.5});
    panel.band(-2.0, 0.0, bandColour(c.before), "");
    panel.band(0.0, kIn_m * 1000.0, bandColour(c.tissue), "");
    panel.axes("depth behind the border [mm]", "force [N]");
    panel.trace(inMillimetres(c.min_a1), 1.2, kBound);
    panel.trace(inMillimetres(c.max_a1), 1.2, kBound);
    panel.trace(inMillimetres(c.out), 1.8, kWithdrawalColour);
    panel.trace(inMillimetres(c.in), 2.4, kInsertionColour);
    const std::string into(patient::tissueName(c.tissue)), from(patient::tissueName(c.before));
    canvas.text({box.left, box.top - 12.0}, into + ", from " + from, {16, kInk, Align::left, true});
    const TextStyle small{13, kInk};
    const double right = box.left + box.width - 176.0;
    if (c.cut) {
        const Point at = panel.at(c.cut_at.depth_m * 1000.0, c.cut_at.force_n);
        canvas.disc(at, 4.0, kPaper);
        canvas.circle(at, 4.0, 2.0, kInsertionColour);
        canvas.text({right, box.top + 22.0},
                    fmt::format("cut at {:.2f} N, {:.3f} mm", c.cut_at.force_n, c.cut_at.depth_m * 1000.0),
                    small);
    } else {
        canvas.text({right, box.top + 22.0}, steep ? "never cut" : "entered without tenting", small);
    }
    canvas.text({right, box.top + 40.0},
                fmt::format("friction {:.2f} N, {:.1f} N/mm", row.friction_n, row.stiffness_n_per_m / 1000.0),
                small);
}

}  // namespace

std::vector<TissueCurve> tissueCurves(const patient::TissueTable& table,
                                      const haptics::NeedleSettings& settings) {
    std::vector<TissueCurve> curves;
    for (const auto& [before, tissue] : kPairs)
        curves.push_back(computeTissueCurve(table, settings, before, tissue));
    return curves;
}

void drawTissueCurves(const std::vector<TissueCurve>& curves, const patient::TissueTable& table,
                      const std::filesystem::path& png) {
    constexpr int kColumns = 3;
    constexpr double kWide = 400.0, kHigh = 400.0;
    const int rows = int(curves.size()) / kColumns + 1;  // a place remains for the legend
    Canvas canvas(int(kColumns * kWide + 20.0), int(80.0 + rows * kHigh), kPaper);
    canvas.text({64, 42}, "What each tissue feels like", {22, kInk, Align::left, true});
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const Box box{64.0 + kWide * double(int(i) % kColumns), 104.0 + kHigh * double(int(i) / kColumns),
                      kWide - 84.0, kHigh - 104.0};
        drawTissue(canvas, box, curves[i], table[std::size_t(curves[i].tissue)]);
    }
    const double x = 64.0 + kWide * double(int(curves.size()) % kColumns), y = 130.0 + kHigh * (rows - 1);
    drawEntry(canvas, {x, y}, kInsertionColour, 2.4, "way in, 10 mm/s at 1 kHz, a1 = k/2");
    drawEntry(canvas, {x, y + 28.0}, kBound, 1.2, "exact, a1 = 0 (below) and a1 = k (above)");
    drawEntry(canvas, {x, y + 56.0}, kWithdrawalColour, 1.8, "way out: friction, reversed");
    canvas.savePng(png);
}

void drawComparison(const Comparison& c, const std::filesystem::path& png) {
    constexpr Colour kFirst{0.20, 0.38, 0.62}, kSecond{0.75, 0.16, 0.14};
    Canvas canvas(1280, 640, kPaper);
    canvas.text({88, 46}, c.title, {22, kInk, Align::left, true});
    Panel panel(canvas, {88.0, 110.0, 1160.0, 450.0}, {0.0, c.length_m * 1000.0, 5.0}, {0.0, 4.0, 0.5});
    for (std::size_t i = 0; i < c.tissues.size(); ++i) {
        const double end_m = i + 1 < c.tissues.size() ? c.tissues[i + 1].begin_m : c.length_m;
        panel.band(c.tissues[i].begin_m * 1000.0, end_m * 1000.0, bandColour(c.tissues[i].tissue),
                   std::string(patient::tissueName(c.tissues[i].tissue)));
    }
    panel.axes("depth of the tip [mm]", "axial force [N]");
    panel.trace(inMillimetres(c.first), 4.5, kFirst.faded(0.55));
    panel.trace(inMillimetres(c.second), 1.8, kSecond);
    for (const Remark& r : c.remarks) {
        const Point p = panel.at(r.begin_m * 1000.0, 3.4);
        canvas.text({p.x, p.y - 6.0}, r.title, {15, kInk, Align::left, true});
        canvas.text({p.x, p.y + 13.0}, r.text, {13, kInk});
        panel.dashed({r.begin_m * 1000.0, 0.0}, {r.begin_m * 1000.0, 3.1}, 1.0, kMuted);
        panel.dashed({r.end_m * 1000.0, 0.0}, {r.end_m * 1000.0, 3.1}, 1.0, kMuted);
    }
    drawEntry(canvas, {88.0, 80.0}, kFirst.faded(0.55), 4.5, c.first_name);
    drawEntry(canvas, {420.0, 80.0}, kSecond, 1.8, c.second_name);
    canvas.savePng(png);
}

}  // namespace stylet::report
