#include "app/trainer/window/layout.h"

#include <algorithm>

namespace stylet::trainer {
namespace {

constexpr int kRoomForKeys = 320;                 // a window with less height shows no key help
constexpr int kKeysShare = 3;                     // the key help takes a third of the height at most
constexpr int kMinWidth = 300, kMinHeight = 160;  // of an overview; a smaller window shows only the eye

Pane pane(WindowView shows, const Rect& all) {
    return {shows,
            {all.x, all.y, all.width, kCaption},
            {all.x, all.y + kCaption, all.width, std::max(1, all.height - kCaption)}};
}

WindowView lastOf(const LayoutSettings& settings) {
    return settings.guide ? WindowView::guide : WindowView::metrics;
}

// The large picture on the left, three others on the right.
void placeWide(std::vector<Pane>& panes, WindowView eye, const Rect& all, const LayoutSettings& settings) {
    const bool slices = settings.slices;
    const int side = std::clamp(all.width * (settings.guide ? 34 : 30) / 100, 200, 520);
    const Rect left{all.x, all.y, all.width - side - kGap, all.height};
    const int below = slices ? std::min(left.width / 3 + kCaption, left.height * 2 / 5) : 0;
    panes.push_back(pane(eye, {left.x, left.y, left.width, left.height - (slices ? below + kGap : 0)}));
    const int x = left.x + left.width + kGap, panes_height = all.height - 2 * kGap,
              each = panes_height * (settings.guide ? 28 : 33) / 100;
    int y = all.y;
    for (const WindowView view : {WindowView::ultrasound, WindowView::xray}) {
        panes.push_back(pane(view, {x, y, side, each}));
        y += each + kGap;
    }
    panes.push_back(pane(lastOf(settings), {x, y, side, all.y + all.height - y}));
    if (slices)
        panes.push_back(pane(WindowView::slices, {left.x, left.y + left.height - below, left.width, below}));
}

// The large picture at the top, the others below.
void placeHigh(std::vector<Pane>& panes, WindowView eye, const Rect& all, const LayoutSettings& settings) {
    const int above = all.height * 55 / 100;
    panes.push_back(pane(eye, {all.x, all.y, all.width, above}));
    const int y = all.y + above + kGap, rest = all.height - above - kGap;
    const int half = (all.width - kGap) / 2, machine = (rest - kGap) / 2;
    panes.push_back(pane(WindowView::ultrasound, {all.x, y, half, machine}));
    panes.push_back(pane(WindowView::xray, {all.x, y + machine + kGap, half, machine}));
    panes.push_back(pane(lastOf(settings), {all.x + half + kGap, y, half, rest}));
}

}  // namespace

int maxKeyRows(int height) {
    return height >= kRoomForKeys ? 1 + (height / kKeysShare - kKeys) / kKeyRowHeight : 0;
}

Layout computeLayout(WindowView view, WindowView eye, int width, int height, const LayoutSettings& settings) {
    Layout layout;
    const int rows = std::min(settings.key_rows, maxKeyRows(height));
    const int keys = rows > 0 ? kKeys + (rows - 1) * kKeyRowHeight : 0;
    layout.keys = {0, height - keys, width, keys};
    const Rect all{kGap, kGap, std::max(1, width - 2 * kGap), std::max(1, height - keys - 2 * kGap)};
    const bool roomy = all.width >= kMinWidth && all.height >= kMinHeight;
    if (view != WindowView::overview || !roomy)
        layout.panes.push_back(pane(view == WindowView::overview ? eye : view, all));
    else if (5 * all.width >= 4 * all.height)
        placeWide(layout.panes, eye, all, settings);
    else
        placeHigh(layout.panes, eye, all, settings);
    return layout;
}

Rect fitted(const Rect& area, int width, int height) {
    if (width <= 0 || height <= 0) return {area.x, area.y, 0, 0};
    const double scale = std::min(double(area.width) / width, double(area.height) / height);
    const int w = std::clamp(int(scale * width + 0.5), 1, area.width);
    const int h = std::clamp(int(scale * height + 0.5), 1, area.height);
    return {area.x + (area.width - w) / 2, area.y + (area.height - h) / 2, w, h};
}

}  // namespace stylet::trainer
