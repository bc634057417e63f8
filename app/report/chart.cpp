#include "app/report/chart.h"

#include <fmt/core.h>

#include <cmath>

namespace stylet::report {

namespace {

constexpr double kNumbers = 13.0, kLabels = 14.0;

std::string tickLabel(double value, double step) {
    return fmt::format("{:.{}f}", std::fabs(value) < 1e-9 ? 0.0 : value, step >= 1.0 ? 0 : 1);
}

}  // namespace

Point Panel::at(double x, double y) const {
    return {box_.left + (x - x_.low) / (x_.high - x_.low) * box_.width,
            box_.top + box_.height - (y - y_.low) / (y_.high - y_.low) * box_.height};
}

void Panel::band(double from_x, double to_x, Colour colour, const std::string& name) {
    const double left = std::round(at(std::fmax(from_x, x_.low), 0).x);
    const double right = std::round(at(std::fmin(to_x, x_.high), 0).x);
    if (right <= left) return;
    canvas_.rectangle(left, box_.top, right - left, box_.height, colour);
    const TextStyle style{kNumbers, kMuted, Align::centre};
    if (canvas_.textWidth(name, style) + 6.0 < right - left)
        canvas_.text({0.5 * (left + right), box_.top + 18.0}, name, style);
}

void Panel::axes(const std::string& x_label, const std::string& y_label) {
    const double right = box_.left + box_.width, bottom = box_.top + box_.height;
    for (int i = int(std::ceil(x_.low / x_.step - 1e-9)); i * x_.step <= x_.high + 1e-9; ++i) {
        const double x = at(i * x_.step, 0).x;
        canvas_.line({x, box_.top}, {x, bottom}, 1, kGrid.faded(0.6));
        canvas_.text({x, bottom + 19.0}, tickLabel(i * x_.step, x_.step), {kNumbers, kInk, Align::centre});
    }
    for (int i = int(std::ceil(y_.low / y_.step - 1e-9)); i * y_.step <= y_.high + 1e-9; ++i) {
        const double y = at(0, i * y_.step).y;
        canvas_.line({box_.left, y}, {right, y}, 1, kGrid.faded(0.6));
        canvas_.text({box_.left - 8.0, y + 5.0}, tickLabel(i * y_.step, y_.step),
                     {kNumbers, kInk, Align::right});
    }
    if (y_.low < 0.0 && y_.high > 0.0)
        canvas_.line({box_.left, at(0, 0).y}, {right, at(0, 0).y}, 1.5, kMuted);
    canvas_.text({0.5 * (box_.left + right), bottom + 40.0}, x_label, {kLabels, kInk, Align::centre});
    canvas_.textUpward({box_.left - 42.0, 0.5 * (box_.top + bottom)}, y_label,
                       {kLabels, kInk, Align::centre});
}

void Panel::trace(const std::vector<Point>& values, double width, Colour colour) {
    std::vector<Point> points;
    for (const Point& v : values) {
        const Point p = at(v.x, v.y);
        if (points.empty() || &v == &values.back() ||
            std::fabs(points.back().x - p.x) + std::fabs(points.back().y - p.y) >= 0.33)
            points.push_back(p);
    }
    canvas_.clip(box_.left, box_.top, box_.width, box_.height);
    canvas_.polyline(points, width, colour);
    canvas_.unclip();
}

void Panel::dashed(Point from, Point to, double width, Colour colour) {
    canvas_.dashed(at(from.x, from.y), at(to.x, to.y), width, colour);
}

}  // namespace stylet::report
