// A chart of a page, as page.js draws it: curves and points over two axes, bands and spans behind them. All
// values are in the units that the axes name.
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
    std::vector<std::string> names{};  // of the places 0, 1, 2, ...: the axis has these in place of numbers
    bool whole = false;                // numbers without a fraction
};

struct FigurePoint {
    double x = 0.0, y = 0.0;  // y not a number: the line has a gap
    std::string text{};       // said in place of the numbers
};

inline constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

// From the Okabe-Ito set, which no form of colour blindness merges; dashes and shapes tell the curves apart
// too.
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
                          // bar); empty: none
    double width = 2.0;
    bool small = false;  // points: dots without a rim, for many
};

struct FigureBand {
    double from = 0.0, to = 0.0;  // along x
    std::string text;
    Colour colour;
};
struct FigureSpan {
    int lane = 0;  // a place of the y axis
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
    double x = 0.0;  // of its middle; as wide as half a place
    double low = 0.0, lower_quartile = 0.0, median = 0.0, upper_quartile = 0.0, high = 0.0;
    Colour colour = kBlue;
};

// What a reader may choose to see in place of the figure's own series.
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
    std::vector<FigureChoice> choices{};  // not empty: the first is shown, `series` and `y` are not
    bool low = false;                     // a little less high than others
};

// For a <script type="application/json"> element: nothing in it can end that element.
std::string figureJson(const Figure&);

std::string hexColour(const Colour&);

// The points in the order given, at most about 4 in each of `buckets` stretches of equally many: the first,
// the lowest, the highest and the last of each, so that no peak is lost. Gaps stay.
std::vector<FigurePoint> thinned(const std::vector<FigurePoint>&, std::size_t buckets);

}  // namespace stylet::report
