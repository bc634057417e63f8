// A panel with axes on a canvas, for pictures with more than one curve or more than one panel.
#pragma once

#include <string>
#include <vector>

#include "app/report/canvas.h"

namespace stylet::report {

inline constexpr Colour kPaper{1, 1, 1}, kInk{0.13, 0.15, 0.18}, kGrid{0.80, 0.82, 0.85},
    kMuted{0.45, 0.48, 0.52};

// Range of an axis, with a grid line every `step`.
struct Range {
    double low = 0.0, high = 1.0, step = 0.5;
};

// Position on the canvas, in pixels.
struct Box {
    double left = 0.0, top = 0.0, width = 0.0, height = 0.0;
};

class Panel {
  public:
    Panel(Canvas& canvas, const Box& box, const Range& x, const Range& y)
        : canvas_(canvas), box_(box), x_(x), y_(y) {}
    Point at(double x, double y) const;
    const Box& box() const { return box_; }
    // Background band over an interval of x, drawn first. The name is drawn if it fits.
    void band(double from_x, double to_x, Colour, const std::string& name);
    void axes(const std::string& x_label, const std::string& y_label);
    // The points are values, not pixels. The curve is clipped to the box.
    void trace(const std::vector<Point>&, double width, Colour);
    void dashed(Point from, Point to, double width, Colour);

  private:
    Canvas& canvas_;
    Box box_;
    Range x_, y_;
};

}  // namespace stylet::report
