#include "app/report/curve.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "app/report/bands.h"
#include "app/report/chart.h"
#include "base/text.h"
#include "base/whole_file.h"

namespace stylet::report {

using haptics::Tissue;

namespace {

constexpr int kCurveWidth = 1280, kCurveHeight = 720;
constexpr double kCurveLeft = 88, kCurveRight = 32, kCurveTop = 108, kCurveBottom = 76;
constexpr Colour kIn{0.75, 0.16, 0.14}, kOut{0.20, 0.38, 0.62};

// Maps data coordinates to pixels.
struct Axes {
    double depth_low_mm, depth_high_mm, force_low_n, force_high_n;
    double x(double depth_m) const {
        return kCurveLeft + (depth_m * 1000.0 - depth_low_mm) / (depth_high_mm - depth_low_mm) *
                                (kCurveWidth - kCurveLeft - kCurveRight);
    }
    double y(double force_n) const {
        return kCurveHeight - kCurveBottom -
               (force_n - force_low_n) / (force_high_n - force_low_n) *
                   (kCurveHeight - kCurveTop - kCurveBottom);
    }
};

Axes fit(const std::vector<ForceSample>& curve) {
    Axes axes{0.0, 10.0, -0.5, 1.0};
    for (const ForceSample& s : curve) {
        axes.depth_low_mm = std::min(axes.depth_low_mm, s.depth_m * 1000.0);
        axes.depth_high_mm = std::max(axes.depth_high_mm, s.depth_m * 1000.0);
        axes.force_low_n = std::min(axes.force_low_n, s.force_n);
        axes.force_high_n = std::max(axes.force_high_n, s.force_n);
    }
    axes.depth_low_mm = 5.0 * std::floor(axes.depth_low_mm / 5.0);
    axes.depth_high_mm = 5.0 * std::ceil(axes.depth_high_mm / 5.0);
    axes.force_low_n = 0.5 * std::floor(axes.force_low_n / 0.5);
    axes.force_high_n = 0.5 * std::ceil(axes.force_high_n / 0.5 + 0.4);
    return axes;
}

std::string number(fmt::format_string<double> format, double value) {
    return fmt::format(format, std::fabs(value) < 1e-9 ? 0.0 : value);  // avoids "-0"
}

std::size_t deepest(const std::vector<ForceSample>& curve) {
    const auto last =
        std::max_element(curve.begin(), curve.end(),
                         [](const ForceSample& a, const ForceSample& b) { return a.depth_m < b.depth_m; });
    return std::size_t(last - curve.begin());
}

void drawBands(Canvas& canvas, const Axes& axes, const std::vector<ForceSample>& curve, std::size_t end) {
    const double bottom = axes.y(axes.force_low_n), top = kCurveTop;
    double named_until = 0.0;
    for (const TissueBand& band : tissueBands(curve, end)) {
        const double from = axes.x(band.from_m), to = axes.x(band.to_m);
        const double left = std::round(from), right = std::round(to);  // avoids seams between bands
        canvas.rectangle(left, top, right - left, bottom - top, bandColour(band.tissue));
        const std::string name(patient::tissueName(band.tissue));
        const TextStyle style{13, kMuted, Align::centre};
        const double middle = 0.5 * (from + to), half = 0.5 * canvas.textWidth(name, style);
        if (to - from < 2.0 * half + 6.0 || middle - half < named_until) continue;
        canvas.text({middle, top + 18}, name, style);
        named_until = middle + half;
    }
}

void drawAxes(Canvas& canvas, const Axes& axes) {
    const double span = axes.depth_high_mm - axes.depth_low_mm;
    const double step = span > 120.0 ? 20.0 : span > 40.0 ? 10.0 : 5.0;
    for (double d = std::ceil(axes.depth_low_mm / step) * step; d <= axes.depth_high_mm + 1e-9; d += step) {
        const double x = axes.x(d / 1000.0);
        canvas.line({x, kCurveTop}, {x, axes.y(axes.force_low_n)}, 1, kGrid.faded(0.6));
        canvas.text({x, axes.y(axes.force_low_n) + 22}, number("{:.0f}", d), {14, kInk, Align::centre});
    }
    const double force_step = axes.force_high_n - axes.force_low_n > 8.0 ? 2.0 : 0.5;
    for (double f = axes.force_low_n; f <= axes.force_high_n + 1e-9; f += force_step) {
        canvas.line({kCurveLeft, axes.y(f)}, {kCurveWidth - kCurveRight, axes.y(f)}, 1, kGrid.faded(0.6));
        canvas.text({kCurveLeft - 10, axes.y(f) + 5}, number("{:.1f}", f), {14, kInk, Align::right});
    }
    canvas.line({kCurveLeft, axes.y(0)}, {kCurveWidth - kCurveRight, axes.y(0)}, 1.5, kMuted);
    canvas.text({0.5 * (kCurveLeft + kCurveWidth - kCurveRight), kCurveHeight - 22},
                "depth of the tip along the track [mm]", {15, kInk, Align::centre});
    canvas.textUpward({30, 0.5 * (kCurveTop + kCurveHeight - kCurveBottom)},
                      "axial force [N], positive resists insertion", {15, kInk, Align::centre});
}

// Draws one line per run of consecutive ticks, because there is no force outside the body. Leaves out steps
// below a third of a pixel.
void drawTrace(Canvas& canvas, const Axes& axes, std::span<const ForceSample> curve, double width,
               Colour colour) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < curve.size(); ++i) {
        const Point p{axes.x(curve[i].depth_m), axes.y(curve[i].force_n)};
        const bool last = i + 1 == curve.size() || curve[i + 1].tick != curve[i].tick + 1;
        if (points.empty() || last ||
            std::fabs(points.back().x - p.x) + std::fabs(points.back().y - p.y) >= 0.33)
            points.push_back(p);
        if (!last) continue;
        canvas.polyline(points, width, colour);
        points.clear();
    }
}

void drawMarks(Canvas& canvas, const Axes& axes, const std::vector<ForceMark>& marks) {
    double last_right = -1e9, last_y = 0.0;
    for (const ForceMark& mark : marks) {
        const Point at{axes.x(mark.depth_m), axes.y(mark.force_n)};
        canvas.disc(at, 4.0, kPaper);
        canvas.circle(at, 4.0, 2.0, kIn);
        const TextStyle style{14, kInk, Align::left, true};
        const double width = canvas.textWidth(mark.text, style);
        const double x = std::min(at.x + 8.0, kCurveWidth - kCurveRight - width);
        // Raise a label that would overlap its neighbour.
        double y = std::max(at.y - 8.0, kCurveTop + 38.0);
        if (x < last_right + 8.0 && std::fabs(y - last_y) < 18.0) y = last_y - 18.0;
        canvas.text({x, y}, mark.text, style);
        last_right = x + width, last_y = y;
    }
}

void drawCurveLegend(Canvas& canvas) {
    const double y = 80;
    canvas.line({kCurveLeft, y - 5}, {kCurveLeft + 34, y - 5}, 2.5, kIn);
    canvas.text({kCurveLeft + 42, y}, "in", {14, kInk});
    canvas.line({kCurveLeft + 84, y - 5}, {kCurveLeft + 118, y - 5}, 1.5, kOut);
    canvas.text({kCurveLeft + 126, y}, "out", {14, kInk});
    canvas.circle({kCurveLeft + 186, y - 5}, 4.0, 2.0, kIn);
    canvas.text({kCurveLeft + 198, y}, "puncture: the force just before the cut", {14, kInk});
}

}  // namespace

void drawCurve(const std::vector<ForceSample>& curve, const std::vector<ForceMark>& marks,
               const std::string& title, const std::filesystem::path& png) {
    Canvas canvas(kCurveWidth, kCurveHeight, kPaper);
    canvas.text({kCurveLeft, 46}, title, {22, kInk, Align::left, true});
    if (curve.empty()) {
        canvas.text({kCurveLeft, 90}, "The needle did not enter the body.", {16, kMuted});
        canvas.savePng(png);
        return;
    }
    const Axes axes = fit(curve);
    const std::size_t turn = deepest(curve);
    drawBands(canvas, axes, curve, turn + 1);
    drawAxes(canvas, axes);
    drawTrace(canvas, axes, std::span(curve).subspan(turn), 1.5, kOut);
    drawTrace(canvas, axes, std::span(curve).first(turn + 1), 2.5, kIn);
    drawMarks(canvas, axes, marks);
    drawCurveLegend(canvas);
    canvas.savePng(png);
}

}  // namespace stylet::report
