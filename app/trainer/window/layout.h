// Layout of the window. Pixels, origin at the top left.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "base/text.h"

namespace stylet::trainer {

// In the order of the number keys, which start at 1.
enum class WindowView : unsigned char {
    leftEye,
    rightEye,
    camera,
    ultrasound,
    xray,
    metrics,
    overview,
    slices,
    guide
};
inline constexpr int kWindowViews = 9;
inline constexpr std::array<std::string_view, kWindowViews> kWindowViewNames{
    "left eye", "right eye", "free camera", "ultrasound", "X-ray", "metrics", "overview", "slices", "guide"};
constexpr std::string_view nameOf(WindowView view) {
    return enumName(kWindowViewNames, view);
}

struct Rect {
    int x = 0, y = 0, width = 0, height = 0;
    bool holds(double px, double py) const { return px >= x && py >= y && px < x + width && py < y + height; }
    friend bool operator==(const Rect&, const Rect&) = default;
};

// A view with a caption above it.
struct Pane {
    WindowView shows = WindowView::leftEye;  // never overview
    Rect caption, area;
};
struct Layout {
    std::vector<Pane> panes;
    Rect keys;  // rows for the key help; height 0 if there is no space
};

struct LayoutSettings {
    int key_rows = 1;
    bool slices = false;  // show the slices in the overview
    bool guide = false;   // show the guide in the overview, in place of the metrics
};

inline constexpr int kCaption = 26, kKeys = 30, kKeyRowHeight = 22, kGap = 8;

// Rows for the key help in a window of this height: a third of it at most, 0 if it is too small.
int maxKeyRows(int height);
// `eye`: the view for the overview's large pane, which shows what the trainee sees.
Layout computeLayout(WindowView, WindowView eye, int width, int height, const LayoutSettings& = {});

// Largest centred rectangle with the picture's aspect ratio. Empty for an empty picture.
Rect fitted(const Rect& area, int width, int height);

}  // namespace stylet::trainer
