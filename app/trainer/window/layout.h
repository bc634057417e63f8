// Where everything stands in the window. Pixels, origin top left.
#pragma once

#include <string>
#include <vector>

namespace stylet::trainer {

// In the order of their keys, from 1 on.
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
const char* nameOf(WindowView);

struct Rect {
    int x = 0, y = 0, width = 0, height = 0;
    bool holds(double px, double py) const { return px >= x && py >= y && px < x + width && py < y + height; }
    friend bool operator==(const Rect&, const Rect&) = default;
};

// A picture or the metrics, with a line above that says what it is.
struct Pane {
    WindowView shows = WindowView::leftEye;  // never overview
    Rect caption, area;
};
struct Layout {
    std::vector<Pane> panes;
    Rect keys;  // the rows that say what the keys do; none where there is no room
};

struct LayoutSettings {
    int key_rows = 1;
    bool slices = false;  // in the overview
    bool guide = false;   // in the overview, in place of the metrics
};

inline constexpr int kCaption = 26, kKeys = 30, kMoreKeys = 22, kGap = 8;

// `eye`: the pane that stands for what the trainee sees in the overview.
Layout layoutOf(WindowView, WindowView eye, int width, int height, const LayoutSettings& = {});

// As large as it fits, in the middle, never stretched. An empty picture: nothing.
Rect fitted(const Rect& area, int width, int height);

}  // namespace stylet::trainer
