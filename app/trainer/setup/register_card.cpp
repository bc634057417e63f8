#include "app/trainer/setup/register_card.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "app/trainer/view/notice.h"

namespace stylet::trainer {

using report::Colour;
using report::Point;
using xr::registration::WizardSketch;
using xr::registration::WizardText;

namespace {

constexpr Colour kGlass{0.05, 0.07, 0.09}, kText{0.93, 0.95, 0.96}, kTitle{1.0, 0.80, 0.30},
    kQuiet{0.60, 0.66, 0.70}, kRail{0.16, 0.20, 0.24}, kDone{0.35, 0.80, 0.50}, kWarning{1.0, 0.55, 0.30},
    kEdge{0.34, 0.40, 0.46}, kTip{0.45, 0.75, 1.0};
constexpr double kMargin_px = 36.0, kTitle_px = 48.0, kPitch_px = 44.0;
constexpr double kSpaceLeft_px = 760.0, kSpaceMiddle_px = 912.0, kSpaceTop_px = 250.0, kHalf_px = 92.0;

// Projects a point of the cube into the picture. The cube is seen from the user's seat, slightly from above
// and from the right, so near points are lower and further to the left.
Point placed(const WizardSketch& sketch, const Vec3& p_m) {
    const Vec3 way = (p_m - sketch.cube.centre_m) / sketch.cube.half_m;
    const Vec3 at(std::clamp(way.x, -1.5, 1.5), std::clamp(way.y, -1.5, 1.5), std::clamp(way.z, -1.5, 1.5));
    return {kSpaceMiddle_px + kHalf_px * (at.x - 0.42 * at.z),
            kSpaceTop_px - kHalf_px * (at.y - 0.36 * at.z)};
}

// Everything on which the picture depends. Positions are in pixels.
std::string fingerprint(const WizardText& t, const WizardSketch& sketch) {
    std::string all =
        t.title + '\n' + t.what + '\n' + t.next_action + '\n' + t.note + (t.is_warning ? '!' : ' ');
    const auto add = [&all](double a, double b) { all += fmt::format("{:.0f},{:.0f};", a, b); };
    add(1000.0 * t.progress, 500.0 * t.recording);
    if (!sketch.shown) return all;
    const auto addPoint = [&](const Vec3& p_m) { add(placed(sketch, p_m).x, placed(sketch, p_m).y); };
    for (const Vec3& p : sketch.done)
        addPoint(p);
    if (sketch.next) addPoint(*sketch.next);
    if (sketch.tip) addPoint(*sketch.tip);
    return all;
}

}  // namespace

RegisterCard::RegisterCard() : canvas_(kWidth, kHeight, kGlass) {}

void RegisterCard::show(const WizardText& text, const WizardSketch& sketch) {
    const std::string now = fingerprint(text, sketch);
    if (revision_ > 0 && now == shown_) return;
    shown_ = now;
    canvas_.rectangle(0.0, 0.0, kWidth, kHeight, kGlass);
    canvas_.rectangle(0.0, 0.0, kWidth, 10.0, kRail);
    canvas_.rectangle(0.0, 0.0, kWidth * text.progress, 10.0, kTitle);
    write(text);
    if (sketch.shown) drawSpace(sketch);
    canvas_.pixels(rgba_);
    ++revision_;
}

void RegisterCard::write(const WizardText& text) {
    const double width_px = kSpaceLeft_px - 2.0 * kMargin_px;
    double y = kMargin_px + kTitle_px;
    canvas_.text({kMargin_px, y}, text.title, {.size = kTitle_px, .colour = kTitle, .bold = true});
    y += 0.35 * kPitch_px;
    const auto paragraph = [&](const std::string& words, const Colour& colour, bool bold) {
        const report::TextStyle style{.size = kLetter_px, .colour = colour, .bold = bold};
        for (const std::string& line : wrapped(canvas_, words, style, width_px))
            canvas_.text({kMargin_px, y += kPitch_px}, line, style);
    };
    paragraph(text.what, kText, false);
    y += 0.3 * kPitch_px;
    if (!text.note.empty()) paragraph(text.note, text.is_warning ? kWarning : kQuiet, false);
    const double bottom = kHeight - kMargin_px;
    canvas_.text({kMargin_px, bottom}, text.next_action, {.size = kLetter_px, .colour = kTip, .bold = true});
    if (text.recording <= 0.0) return;
    const double left = kSpaceLeft_px, width = kWidth - kMargin_px - left, top = bottom - 20.0;
    canvas_.rectangle(left, top, width, 18.0, kRail);
    canvas_.rectangle(left, top, width * text.recording, 18.0, kDone);
}

void RegisterCard::drawSpace(const WizardSketch& sketch) {
    const Vec3 &centre = sketch.cube.centre_m, half(sketch.cube.half_m);
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 way(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        for (int axis = 0; axis < 3; ++axis) {
            if (way[axis] > 0.0) continue;
            Vec3 other = way;
            other[axis] = 1.0;
            canvas_.line(placed(sketch, centre + half * way), placed(sketch, centre + half * other), 2.0,
                         kEdge);
        }
    }
    for (const Vec3& place : sketch.to_do)
        canvas_.circle(placed(sketch, place), 7.0, 2.5, kQuiet);
    for (const Vec3& place : sketch.done)
        canvas_.disc(placed(sketch, place), 6.0, kDone);
    if (sketch.next) canvas_.circle(placed(sketch, *sketch.next), 15.0, 5.0, kTitle);
    if (sketch.tip) canvas_.disc(placed(sketch, *sketch.tip), 9.0, kTip);
    canvas_.text({kSpaceMiddle_px, kSpaceTop_px + 2.25 * kHalf_px}, "from your side",
                 {.size = kLetter_px, .colour = kQuiet, .align = report::Align::centre});
}

}  // namespace stylet::trainer
