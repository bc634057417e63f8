#include "app/trainer/guide_panel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <limits>

#include "app/trainer/notice.h"
#include "app/trainer/staging.h"

namespace stylet::trainer {

using patient::Pose;
using patient::Vec3;
using training::Progress;
using training::Step;

namespace {

constexpr report::Colour kGlass{0.05, 0.07, 0.09}, kText{0.93, 0.95, 0.96}, kQuiet{0.62, 0.69, 0.73},
    kDone{0.35, 0.80, 0.95}, kNext{1.0, 0.80, 0.30}, kGrid{0.20, 0.25, 0.29};
constexpr double kLeft = 30.0, kRight = GuidePanel::kWidth - 30.0, kNumber_px = 40.0;
constexpr double kCurveTop = 416.0, kCurveBottom = 556.0, kLeastFull_n = 3.0;
constexpr double kInView_rad = 0.95;  // beyond, no lens shows it
// To the panel's lower left corner: beyond the table, toward the feet.
constexpr Vec3 kCornerFromEntry_m{0.16, -0.04, -0.42};
constexpr int kPlaceRounds = 12;
// Where pixels are few its letters stay smaller than they should be: it would fill the room.
constexpr double kMostWidth_m = 1.2;
constexpr double kBreathMoves_v = 0.002;

std::string printed(const char* format, double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::string clockOf(double s) {
    const long whole = std::lround(std::floor(std::max(0.0, s)));
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%ld:%02ld", whole / 60, whole % 60);
    return text.data();
}

bool isDone(const Progress& progress, int step) {
    return (progress.steps_done & (1u << unsigned(step))) != 0;
}

}  // namespace

std::string_view hintOf(Step step) noexcept {
    switch (step) {
        case Step::findGap:
            return "With a finger, feel for the gap between two ribs at the marked entry.";
        case Step::findDuct:
            return "Put the probe there and turn it until the target duct stands on the guide's line.";
        case Step::incise:
            return "Open the skin at the entry with the scalpel, a few millimetres.";
        case Step::guide:
            return "Lay the needle into the probe's guide: it snaps in with a click.";
        case Step::advance:
            return "Have the breath held, and advance under ultrasound until the duct gives way.";
        case Step::contrast:
            return "Inject a little contrast medium and look at the ducts under X-rays.";
        case Step::done:
            break;
    }
    return "All steps are done.";
}

GuidePanel::GuidePanel(training::Difficulty difficulty, double tick_s)
    : hints_(training::hintsOf(difficulty)), tick_s_(tick_s), canvas_(kWidth, kHeight, kGlass) {}

void GuidePanel::take(const Seen& seen, bool looked_at) {
    const double t_s = tick_s_ * double(seen.tick.tick);
    if (!curve_.empty() && t_s < curve_.back().t_s) {
        if (t_s > curve_.front().t_s) return;  // a moment that is shown late
        curve_.clear();
        drawn_s_ = 0.0;
    }
    if (curve_.empty() || t_s - curve_.back().t_s >= 0.5 * kEvery_s) {
        const double moved_v = seen.tick.breath.v - breath_v_;
        breath_ = seen.tick.breath_held                 ? "held"
                  : std::fabs(moved_v) < kBreathMoves_v ? "at rest"
                  : moved_v > 0.0                       ? "in"
                                                        : "out";
        breath_v_ = seen.tick.breath.v;
        curve_.push_back({t_s, seen.tick.force_n});
        while (curve_.front().t_s < t_s - kCurve_s)
            curve_.pop_front();
    }
    if (!looked_at || (revision_ > 0 && t_s - drawn_s_ < kEvery_s && t_s >= drawn_s_)) return;
    now_s_ = drawn_s_ = t_s;
    draw(seen);
}

void GuidePanel::number(double x, double y, const char* name, const std::string& value) {
    canvas_.text({x, y}, name, {.size = kLetter_px, .colour = kQuiet});
    canvas_.text({x, y + kNumber_px + 4.0}, value, {.size = kNumber_px, .colour = kText, .bold = true});
}

// A square for each, filled when it is done: the shape says it, not the colour alone.
void GuidePanel::drawSteps(const Progress& progress) {
    constexpr double kBox = 26.0, kPitch = 40.0;
    for (int step = 0; step < training::kStepCount; ++step) {
        const double x = kRight - kPitch * (training::kStepCount - step) + kPitch - kBox, y = 24.0;
        const bool next = progress.step == Step(step);
        canvas_.rectangle(x, y, kBox, kBox, next ? kNext : kQuiet);
        if (!isDone(progress, step)) canvas_.rectangle(x + 3.0, y + 3.0, kBox - 6.0, kBox - 6.0, kGlass);
        if (isDone(progress, step)) canvas_.rectangle(x + 3.0, y + 3.0, kBox - 6.0, kBox - 6.0, kDone);
    }
}

void GuidePanel::drawCurve() {
    double full_n = kLeastFull_n;
    for (const Sample& s : curve_)
        full_n = std::max(full_n, std::ceil(std::fabs(s.force_n)));
    const double left = kLeft + 62.0;
    const auto y = [&](double n) { return kCurveBottom - (kCurveBottom - kCurveTop) * n / full_n; };
    for (const double n : {0.0, full_n}) {
        canvas_.line({left, y(n)}, {kRight, y(n)}, 1.5, kGrid);
        canvas_.text({left - 10.0, y(n) + 9.0}, printed("%.0f N", n),
                     {.size = kLetter_px, .colour = kQuiet, .align = report::Align::right});
    }
    line_.clear();
    for (const Sample& s : curve_)
        line_.push_back({kRight - (kRight - left) * (now_s_ - s.t_s) / kCurve_s, y(std::fabs(s.force_n))});
    if (line_.size() > 1) canvas_.polyline(line_, 3.0, kText);
}

void GuidePanel::draw(const Seen& seen) {
    const Progress& progress = seen.progress;
    const haptics::TickOutput& tick = seen.tick;
    const bool inside = tick.phase != haptics::Phase::outside;
    canvas_.rectangle(0.0, 0.0, kWidth, kHeight, kGlass);
    const bool finished = progress.step == Step::done;
    canvas_.text({kLeft, 48.0},
                 finished ? "Done"
                          : "Step " + std::to_string(int(progress.step) + 1) + " of " +
                                std::to_string(training::kStepCount),
                 {.size = 34.0, .colour = kNext, .bold = true});
    drawSteps(progress);
    double y = 92.0;
    const report::TextStyle words{.size = 28.0, .colour = kText};
    const std::string said{hints_.next_step ? hintOf(progress.step) : training::stepName(progress.step)};
    for (const std::string& line : wrapped(canvas_, said, words, kRight - kLeft))
        canvas_.text({kLeft, y}, line, words), y += 36.0;

    constexpr double kColumns[3] = {kLeft, 268.0, 496.0};
    number(kColumns[0], 190.0, "Depth", inside ? printed("%.1f mm", 1e3 * tick.depth_m) : "outside");
    number(kColumns[1], 190.0, "Force", printed("%.2f N", std::fabs(tick.force_n)));
    number(kColumns[2], 190.0, "Tissue", inside ? std::string(patient::tissueName(tick.tissue)) : "air");
    number(kColumns[0], 282.0, "Off the path", printed("%.1f mm", 1e3 * progress.off_path_m));
    number(kColumns[1], 282.0, "Angle", printed("%.1f\u00b0", progress.off_angle_rad * 57.29577951308232));
    number(kColumns[2], 282.0, "To the target", printed("%.0f mm", 1e3 * progress.to_target_m));
    canvas_.text({kLeft, 392.0}, "Force over the last 10 s", {.size = kLetter_px, .colour = kQuiet});
    drawCurve();
    const double last = kHeight - 28.0;
    const report::TextStyle foot{.size = 30.0, .colour = kText, .bold = true};
    canvas_.text({kColumns[0], last}, clockOf(progress.elapsed_s), foot);
    canvas_.text({kColumns[1] - 70.0, last}, "Breath " + std::string(breath_), foot);
    canvas_.text({kColumns[2], last}, "Score " + printed("%.0f", progress.total), foot);
    canvas_.pixels(rgba_);
    ++revision_;
}

PanelPlace guidePlace(const Vec3& stage_entry_m, const Vec3& stage_eyes_m, double letter_rad) {
    const Vec3 corner = stage_entry_m + kCornerFromEntry_m;
    PanelPlace place;
    Vec3 middle = corner;
    // The larger it is, the farther its middle, for which it is made.
    for (int i = 0; i < kPlaceRounds; ++i) {
        place.width_m = std::min(kMostWidth_m, GuidePanel::kWidth / GuidePanel::kLetter_px *
                                                   glm::length(middle - stage_eyes_m) * std::tan(letter_rad));
        place.height_m = place.width_m * GuidePanel::kHeight / GuidePanel::kWidth;
        middle = corner + Vec3(0.5 * place.width_m, 0.5 * place.height_m, 0.0);
    }
    place.stage_from_panel = {stageFromEyes(stage_eyes_m, middle).rotation, middle};
    return place;
}

bool covers(const PanelPlace& place, const Vec3& stage_eyes_m, const Vec3& stage_point_m) {
    const Pose panel_from_stage = place.stage_from_panel.inverse();
    const Vec3 eyes = panel_from_stage * stage_eyes_m, point = panel_from_stage * stage_point_m;
    if (eyes.z * point.z > 0.0) return false;  // on the same side
    const double share = eyes.z == point.z ? 0.0 : eyes.z / (eyes.z - point.z);
    const Vec3 met = eyes + share * (point - eyes);
    return std::fabs(met.x) <= 0.5 * place.width_m && std::fabs(met.y) <= 0.5 * place.height_m;
}

bool inView(const PanelPlace& place, const Pose& stage_from_head) {
    const Pose head_from_panel = stage_from_head.inverse() * place.stage_from_panel;
    if ((place.stage_from_panel.inverse() * stage_from_head.position_m).z <= 0.0) return false;
    for (const double x : {-0.5, 0.0, 0.5})
        for (const double y : {-0.5, 0.0, 0.5}) {
            const Vec3 at = head_from_panel * Vec3(x * place.width_m, y * place.height_m, 0.0);
            if (-at.z > std::cos(kInView_rad) * glm::length(at)) return true;
        }
    return false;
}

}  // namespace stylet::trainer
