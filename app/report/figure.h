// A chart of a page, as page.js draws it: curves and points over two axes, with bands and spans behind
// them. All values are in the units named by the axes.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "app/report/canvas.h"

namespace stylet::report {

struct FigureAxis {
    std::string title;
    std::optional<double> min{}, max{};
    std::vector<std::string> names{};  // axis labels at 0, 1, 2, ... instead of numbers
    bool whole = false;                // integers only
};

struct FigurePoint {
    double x = 0.0, y = 0.0;  // y NaN: a gap in the line
    std::string text{};       // shown instead of the numbers
};

inline constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

// Colours based on the Okabe-Ito palette, which is safe for colour blindness. Dashes and shapes also
// distinguish the curves.
inline constexpr Colour kBlue{0.0, 0.447, 0.698}, kVermilion{0.835, 0.369, 0.0}, kGreen{0.0, 0.478, 0.353},
    kPurple{0.65, 0.30, 0.50}, kOrange{0.902, 0.624, 0.0}, kSky{0.337, 0.706, 0.914},
    kBlack{0.09, 0.13, 0.17};

struct FigureSeries {
    std::string name;
    Colour colour = kBlue;
    std::vector<FigurePoint> points{};
    bool line = true;
    std::vector<int> dash{};
    std::string shape{};  // of the points: circle, rect, rectRot, triangle, cross, crossRot, star, line (a
                          // bar); empty: no points
    double width = 2.0;
    bool small = false;  // dots without a rim, for many points
};

struct FigureBand {
    double from = 0.0, to = 0.0;  // along x
    std::string text;
    Colour colour;
};
struct FigureSpan {
    int lane = 0;  // position on the y axis
    double from = 0.0, to = 0.0;
    std::string text;
    Colour colour;
};
struct FigureLine {
    double y = 0.0;
    std::string text;
};

// A box plot's box: whiskers from `low` to `high`, a bar at the median.
struct FigureBox {
    double x = 0.0;  // centre; the box is half a position wide
    double low = 0.0, lower_quartile = 0.0, median = 0.0, upper_quartile = 0.0, high = 0.0;
    Colour colour = kBlue;
};

// Alternative content of a figure. The reader selects one of them.
struct FigureChoice {
    std::string name;
    FigureAxis y;
    std::vector<FigureSeries> series;
};

struct Figure {
    FigureAxis x, y;
    std::vector<FigureSeries> series{};
    std::vector<FigureBand> bands{};
    std::vector<FigureSpan> spans{};
    std::vector<FigureBox> boxes{};
    std::vector<FigureLine> lines{};
    std::vector<FigurePoint> marks{};
    std::vector<FigureChoice> choices{};  // if not empty, the first is shown instead of `series` and `y`
    bool low = false;                     // drawn slightly less high than other figures
};

// JSON for a <script type="application/json"> element. Escaped so that no text can end the element.
std::string figureJson(const Figure&);

std::string hexColour(const Colour&);

// Thins the points for drawing, in order. Divides them into `buckets` groups of equal size and keeps about
// 4 points of each: first, lowest, highest and last. No peak is lost, and gaps remain.
std::vector<FigurePoint> downsample(const std::vector<FigurePoint>&, std::size_t buckets);

}  // namespace stylet::report
