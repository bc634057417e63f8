// Layout of the window. Pixels, origin at the top left.
#pragma once

#include <string>
#include <vector>

namespace stylet::trainer {

// In the order of their number keys, starting at 1.
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

// A view with a caption above it.
struct Pane {
    WindowView shows = WindowView::leftEye;  // never overview
    Rect caption, area;
};
struct Layout {
    std::vector<Pane> panes;
    Rect keys;  // rows with the key help; height 0 if there is no room
};

struct LayoutSettings {
    int key_rows = 1;
    bool slices = false;  // show the slices in the overview
    bool guide = false;   // show the guide in the overview, in place of the metrics
};

inline constexpr int kCaption = 26, kKeys = 30, kMoreKeys = 22, kGap = 8;

// `eye`: the view that shows in the overview what the trainee sees.
Layout layoutOf(WindowView, WindowView eye, int width, int height, const LayoutSettings& = {});

// Largest centred rectangle with the picture's aspect ratio. Empty for an empty picture.
Rect fitted(const Rect& area, int width, int height);

}  // namespace stylet::trainer
