#include "app/trainer/view/guide_panel.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/session/input_names.h"
#include "app/trainer/view/notice.h"
#include "base/text.h"

namespace stylet::trainer {

using training::Progress;
using training::Step;

namespace {

constexpr report::Colour kPanelGlass{0.05, 0.07, 0.09}, kPanelText{0.93, 0.95, 0.96},
    kPanelQuiet{0.62, 0.69, 0.73}, kDone{0.35, 0.80, 0.95}, kNext{1.0, 0.80, 0.30}, kRisk{1.0, 0.45, 0.38},
    kPanelGrid{0.20, 0.25, 0.29};
constexpr double kLeft = 30.0, kRight = GuidePanel::kWidth - 30.0, kNumber_px = 40.0;
constexpr double kEasy_px = 16.0;   // from this letter size on, the flat layout is not needed
constexpr double kFlat_px = 560.0;  // below this height, numbers are beside their names
constexpr double kMinFull_n = 3.0, kScale_px = 62.0;  // smallest full scale of the force; axis label width
constexpr double kRow_px = GuidePanel::kLetter_px + 4.0, kBetweenNames_px = 8.0;
constexpr int kMaxNameRows = 3;
constexpr double kSwatch_px = 12.0, kBesideSwatch_px = 4.0;  // of a band's colour, before its name
constexpr double kDepthStep_m = 0.020, kMinDepth_m = 0.040, kBeyondTip_m = 0.004;
constexpr double kInView_rad = 0.95;  // half the field of view; no lens shows more
// From the path's entry to the panel's lower left corner: beyond the table, toward the feet.
constexpr Vec3 kCornerFromEntry_m{0.16, -0.04, -0.42};
constexpr int kPlaceRounds = 12;
// Upper limit of the panel's width, so that it does not fill the room. On a display with few pixels, the
// letters are then smaller than they should be.
constexpr double kMaxWidth_m = 1.2;
constexpr double kBreathMoves_v = 0.002;
constexpr double kTouch_n = 0.001;  // smallest force of a tool on the skin
constexpr double kRefusalShown_s = 8.0, kVerdictShown_s = 5.0, kHintShown_s = 5.0;

std::string formatClock(double s) {
    const long whole = std::lround(std::floor(std::max(0.0, s)));
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

// Colour of a tissue's band on the dark glass. The name beside it carries the same information.
report::Colour bandColour(patient::Tissue tissue) {
    constexpr std::array<report::Colour, patient::kTissueCount> kBands{{{0.20, 0.34, 0.42},
                                                                        {0.52, 0.36, 0.27},
                                                                        {0.40, 0.36, 0.17},
                                                                        {0.52, 0.51, 0.48},
                                                                        {0.42, 0.36, 0.62},
                                                                        {0.42, 0.20, 0.17},
                                                                        {0.16, 0.29, 0.60},
                                                                        {0.16, 0.46, 0.20},
                                                                        {0.36, 0.46, 0.48}}};
    return kBands[std::size_t(tissue)];
}

double maxDepth_m(const Insertion& insertion) {
    return insertion.felt.empty() ? 0.0 : double(insertion.felt.back().depth_m);
}

// Length of the straight track, from the skin to where the needle's tip was.
double trackLength_m(const haptics::TickOutput& tick) {
    return glm::length(tick.access.base_m - tick.access.entry_m);
}

// Depth of the tip of the wire, the dilator or the drain in hand. Not positive outside the body.
double depthOnTrack_m(const haptics::TickOutput& tick) {
    if (tick.tool == haptics::Tool::dilator) return tick.access.dilator_m;
    if (tick.tool == haptics::Tool::drain) return tick.access.drain_m;
    return tick.access.wire_in ? trackLength_m(tick) + tick.access.wire_m : 0.0;
}

// Steps of the attempt's course before this one.
int stepsBefore(const Progress& progress, Step step) {
    const std::uint32_t before = (1u << unsigned(step)) - 1u;
    return std::popcount(training::stepsOf(progress) & before);
}

// Whether the newest answer about the case was right, and why; for a while.
std::string answerVerdict(const FrameState& seen) {
    const Progress& progress = seen.progress;
    if (!seen.patient_case || progress.answered == 0 ||
        progress.elapsed_s - progress.answered_s >= kVerdictShown_s)
        return "";
    const auto question = training::Question(progress.answered - 1);
    const bool yes = (progress.yes & 1u << unsigned(question)) != 0;
    return (yes == rightAnswer(*seen.patient_case, question) ? "Right: " : "Wrong: ") +
           describeReason(*seen.patient_case, question) + ".";
}

}  // namespace

const training::Controls& controlsOf(const std::string& device) {
    if (device == kMouse) return training::kMouseControls;
    if (device == kControllers) return training::kControllerControls;
    if (device == "falcon") return training::kFalconControls;
    const bool typed = device == kScriptedDevice || device == kReplayDevice || device == "spacemouse";
    return typed ? training::kTypedControls : training::kForceControls;
}

GuidePanel::GuidePanel(const training::DifficultyRules& rules, const training::Controls& controls,
                       double tick_s)
    : rules_(rules), controls_(controls), tick_s_(tick_s) {
    resize(kWidth, kHeight);
}

std::pair<int, int> GuidePanel::sizeIn(int width_px, int height_px) {
    const double flat =
        std::clamp(double(kWidth) * height_px / std::max(1, width_px), double(kMinHeight), double(kHeight));
    const double tall = kLetter_px * height_px / kHeight >= kEasy_px ? double(kHeight) : flat;
    const double scale = std::min(double(width_px) / kWidth, height_px / tall);
    return {std::max(1, int(scale * kWidth)), std::max(1, int(scale * tall))};
}

void GuidePanel::resize(int width_px, int height_px) {
    canvas_.emplace(width_px, height_px, kPanelGlass);
    const double scale = double(width_px) / kWidth;
    canvas_->scale(scale);
    height_ = height_px / scale;
    drawn_s_ = -kCurve_s;
}

void GuidePanel::update(const FrameState& seen, bool looked_at) {
    const double t_s = tick_s_ * double(seen.tick.tick);
    // An earlier tick adds no sample to the curve (a capture shown late). A tick before the whole curve
    // clears it (a replay that goes back).
    if (!curve_.empty() && t_s < curve_.front().t_s) curve_.clear();
    if (curve_.empty() || t_s - curve_.back().t_s >= 0.5 * kEvery_s) {
        const double moved_v = seen.tick.breath.v - breath_v_;
        breath_ = seen.tick.breath_held                 ? "held"
                  : std::fabs(moved_v) < kBreathMoves_v ? "at rest"
                  : moved_v > 0.0                       ? "in"
                                                        : "out";
        breath_v_ = seen.tick.breath.v;
        curve_.push_back({t_s, std::fabs(toolForce_n(seen.tick))});
        while (curve_.front().t_s < t_s - kCurve_s)
            curve_.pop_front();
    }
    if (!looked_at || (revision_ > 0 && std::fabs(t_s - drawn_s_) < kEvery_s)) return;
    now_s_ = drawn_s_ = t_s;
    draw(seen);
}

void GuidePanel::number(double x, double to_x, double y, const char* name, const std::string& value) {
    const report::TextStyle quiet{.size = kLetter_px, .colour = kPanelQuiet};
    canvas_->text({x, y}, name, quiet);
    const bool flat = isFlat();
    const report::Point at = flat ? report::Point{x + canvas_->textWidth(name, quiet) + 10.0, y}
                                  : report::Point{x, y + kNumber_px + 4.0};
    report::TextStyle style{.size = flat ? kLetter_px + 2.0 : kNumber_px, .colour = kPanelText, .bold = true};
    if (const double width = canvas_->textWidth(value, style), space = to_x - 12.0 - at.x; width > space)
        style.size *= space / width;
    canvas_->text(at, value, style);
}

// Draws a square per step. It is filled when the step is done, so that the shape carries the information as
// well as the colour.
void GuidePanel::drawSteps(const Progress& progress) {
    constexpr double kMaxPitch = 40.0, kGap = 14.0, kWhole = 360.0;  // beside the step's number
    const int count = stepsBefore(progress, Step::done);
    const double pitch = std::min(kMaxPitch, kWhole / count), box = pitch - kGap;
    for (int s = 0; s < training::kStepCount; ++s) {
        const auto step = Step(s);
        if (!training::contains(training::stepsOf(progress), step)) continue;
        const double x = kRight - pitch * (count - stepsBefore(progress, step)) + kGap, y = 24.0;
        const bool next = progress.step == step;
        canvas_->rectangle(x, y, box, box, next ? kNext : kPanelQuiet);
        canvas_->rectangle(x + 3.0, y + 3.0, box - 6.0, box - 6.0,
                           training::contains(progress.steps_done, step) ? kDone : kPanelGlass);
    }
}

void GuidePanel::drawForceScale(double top, double bottom, double full_n) {
    for (const double n : {0.0, full_n}) {
        const double y = n == 0.0 ? bottom : top;
        canvas_->line({kLeft + kScale_px, y}, {kRight, y}, 1.5, kPanelGrid);
        canvas_->text({kLeft + kScale_px - 10.0, y + 9.0}, fmt::format("{:.0f} N", n),
                      {.size = kLetter_px, .colour = kPanelQuiet, .align = report::Align::right});
    }
}

void GuidePanel::drawCurve(double top, double bottom) {
    canvas_->text({kLeft, top + kLetter_px}, "Force over the last 10 s",
                  {.size = kLetter_px, .colour = kPanelQuiet});
    top += kRow_px + 14.0;
    double full_n = kMinFull_n;
    for (const Sample& s : curve_)
        full_n = std::max(full_n, std::ceil(std::fabs(s.force_n)));
    drawForceScale(top, bottom, full_n);
    const double left = kLeft + kScale_px;
    line_.clear();
    for (const Sample& s : curve_)
        if (s.t_s <= now_s_)
            line_.push_back({kRight - (kRight - left) * (now_s_ - s.t_s) / kCurve_s,
                             bottom - (bottom - top) * std::fabs(s.force_n) / full_n});
    if (line_.size() > 1) canvas_->polyline(line_, 3.0, kPanelText);
}

// Draws the name and depth of each tissue at a pole on its border, beside the force scale. If space is short,
// risks have priority, then tissues other than fat and muscle; of these, the deepest.
void GuidePanel::drawNames(const Insertion& insertion, double top, double bottom, double full_m) {
    const double left = kLeft + kScale_px;
    const int rows = int((bottom - top) / kRow_px);
    std::array<std::vector<std::pair<double, double>>, kMaxNameRows>
        taken;  // occupied intervals per row, lowest row first
    const auto isFree = [&](int row, double from, double to) {
        return std::none_of(taken[std::size_t(row)].begin(), taken[std::size_t(row)].end(),
                            [&](const auto& t) { return from < t.second && to > t.first; });
    };
    std::vector<const Passed*> order;
    for (const Passed& passed : insertion.passed)
        order.push_back(&passed);
    std::ranges::sort(order, {}, [](const Passed* p) {
        const int group = p->role == patient::Role::risk ? 0 : p->tissue != patient::Tissue::soft ? 1 : 2;
        return std::pair(group, -p->depth_m);
    });
    for (const Passed* passed : order) {
        const bool risk = passed->role == patient::Role::risk;
        const std::string name =
            fmt::format("{}{} {:.0f}", risk ? "! " : "", passed->name, 1e3 * passed->depth_m);
        const report::TextStyle style{.size = kLetter_px, .colour = risk ? kRisk : kPanelText, .bold = risk};
        const double pole = left + (kRight - left) * passed->depth_m / full_m;
        const double width = kSwatch_px + kBesideSwatch_px + canvas_->textWidth(name, style);
        // Take the lowest free row, prefer the right side of the pole, and do not cross another pole.
        std::optional<double> x;
        int row = 0;
        for (; row < rows && isFree(row, pole - 3.0, pole + 3.0); ++row) {
            for (const double from : {std::min(pole, kRight - width), pole - width})
                if (!x && from >= left && isFree(row, from, from + width + kBetweenNames_px)) x = from;
            if (x) break;
        }
        if (!x) continue;
        taken[std::size_t(row)].emplace_back(*x - kBetweenNames_px, *x + width + kBetweenNames_px);
        for (int below = 0; below < row; ++below)
            taken[std::size_t(below)].emplace_back(pole - 4.0, pole + 4.0);
        const double baseline = bottom - row * kRow_px - 8.0;
        // The band's colour, because a name is wider than many bands and may stand above another.
        canvas_->rectangle(*x, baseline - kSwatch_px - 3.0, kSwatch_px, kSwatch_px,
                           bandColour(passed->tissue));
        canvas_->text({*x + kSwatch_px + kBesideSwatch_px, baseline}, name, style);
        canvas_->line({pole, baseline + 5.0}, {pole, bottom}, 2.0, risk ? kRisk : kPanelQuiet);
    }
}

// Draws force over depth for the insertion. The tissues are coloured bands with their names above. Risk
// structures are striped.
void GuidePanel::drawInsertion(const FrameState& seen, double top, double bottom) {
    const Insertion& insertion = seen.insertion;
    const bool inside = seen.tick.phase != haptics::Phase::outside;
    double deepest_m = std::max(kMinDepth_m, insertion.passed.back().depth_m), full_n = kMinFull_n;
    for (const Insertion::Felt& felt : insertion.felt) {
        deepest_m = std::max(deepest_m, double(felt.depth_m));
        full_n = std::max(full_n, std::ceil(double(felt.force_n)));
    }
    const double full_m = kDepthStep_m * std::ceil((deepest_m + kBeyondTip_m) / kDepthStep_m);
    canvas_->text(
        {kLeft, top + kLetter_px},
        fmt::format("Force over depth, 0 to {:.0f} mm{}", 1e3 * full_m, inside ? "" : ", the last time"),
        {.size = kLetter_px, .colour = kPanelQuiet});
    top += kRow_px + 6.0;
    const int rows = std::clamp(int((bottom - top) / 2.0 / kRow_px), 1, kMaxNameRows);
    const double plot = top + rows * kRow_px + 4.0;
    drawNames(insertion, top, plot, full_m);

    const double left = kLeft + kScale_px;
    const auto x = [&](double depth_m) { return left + (kRight - left) * depth_m / full_m; };
    for (std::size_t i = 0; i < insertion.passed.size(); ++i) {
        const Passed& passed = insertion.passed[i];
        const double end_m = i + 1 < insertion.passed.size()
                                 ? insertion.passed[i + 1].depth_m
                                 : std::max(maxDepth_m(insertion), passed.depth_m);
        const double from = x(passed.depth_m), width = std::max(2.0, x(end_m) - from);
        canvas_->rectangle(from, plot, width, bottom - plot, bandColour(passed.tissue));
        if (passed.role != patient::Role::risk) continue;
        canvas_->clip(from, plot, width, bottom - plot);
        for (double at = from - (bottom - plot); at < from + width; at += 12.0)
            canvas_->line({at, bottom}, {at + bottom - plot, plot}, 3.0, kRisk);
        canvas_->unclip();
    }
    drawForceScale(plot, bottom, full_n);
    line_.clear();
    for (const Insertion::Felt& felt : insertion.felt)
        line_.push_back({x(double(felt.depth_m)), bottom - (bottom - plot) * double(felt.force_n) / full_n});
    if (line_.size() > 1) canvas_->polyline(line_, 3.0, kPanelText);
    if (inside) canvas_->line({x(seen.tick.depth_m), plot}, {x(seen.tick.depth_m), bottom}, 3.0, kNext);
}

// The prompt; if the trainee does not get on, a hint takes its place every other kHintShown_s.
std::string GuidePanel::promptText() const {
    const double late_s = now_s_ - act_since_s_ - training::kHintAfter_s;
    const bool hints = late_s >= 0.0 && std::fmod(late_s, 2.0 * kHintShown_s) < kHintShown_s;
    const std::string hint = hints ? training::hint(act_, controls_) : "";
    return hint.empty() ? training::prompt(act_, controls_) : hint;
}

bool GuidePanel::isFlat() const {
    return height_ < kFlat_px;
}

std::array<double, 4> GuidePanel::numberColumns() const {
    const bool flat = isFlat();
    return {kLeft, flat ? 262.0 : 268.0, flat ? 466.0 : 496.0, kRight + 12.0};
}

double GuidePanel::drawNumbers(const FrameState& seen, double y) {
    const Progress& progress = seen.progress;
    const haptics::TickOutput& tick = seen.tick;
    const bool flat = isFlat(), inside = tick.phase != haptics::Phase::outside;
    const std::array<double, 4> columns = numberColumns();
    const double force_n = std::fabs(toolForce_n(tick));
    const bool needle = haptics::isNeedleTool(tick.tool) || tick.access.needle_in,
               presses = haptics::pressesOnSkin(tick.tool) && force_n > kTouch_n;
    // Wire, dilator and drain move along the track only. Their depth has their name, because several of them
    // can be in the body.
    const bool on_track = haptics::isAccessTool(tick.tool);
    const double depth_m = on_track ? depthOnTrack_m(tick) : tick.depth_m;
    const std::string tool_name = capitalised(haptics::kToolNames[std::size_t(tick.tool)]);
    number(columns[0], columns[1], y, on_track ? tool_name.c_str() : "Depth",
           (on_track ? depth_m > 0.0 : needle && inside) ? fmt::format("{:.1f} mm", 1e3 * depth_m)
           : presses                                     ? "skin"
                                                         : "outside");
    number(columns[1], columns[2], y, "Force", fmt::format("{:.2f} N", force_n));
    if (tick.tool == haptics::Tool::wire)
        number(columns[2], columns[3], y, flat ? "In duct" : "In the duct",
               fmt::format("{:.0f} mm", 1e3 * tick.access.in_duct_m));
    else if (on_track)
        number(columns[2], columns[3], y, flat ? "Needle" : "Needle was at",
               fmt::format("{:.0f} mm", 1e3 * trackLength_m(tick)));
    else
        number(columns[2], columns[3], y, "Tissue",
               needle && inside ? std::string(patient::tissueName(tick.tissue))
               : presses        ? "skin"
                                : "air");
    y += flat ? 38.0 : 84.0;
    const auto off = [&](double value, const char* unit, int digits) {
        return on_track ? "\u2013" : fmt::format("{:.{}f}{}", value, digits, unit);
    };
    number(columns[0], columns[1], y, flat ? "Off" : "Off the path",
           off(1e3 * progress.off_path_m, " mm", 1));
    number(columns[1], columns[2], y, "Angle", off(progress.off_angle_rad * 57.29577951308232, "\u00b0", 1));
    // The syringe's own scale shows the total (notice.h).
    if (progress.step == Step::anaesthetise && haptics::isNeedleTool(tick.tool))
        number(columns[2], columns[3], y, flat ? "Here" : "Injected here",
               progress.depot_wanted_m3 > 0.0
                   ? fmt::format("{:.1f} of {:g} ml", 1e6 * progress.depot_m3, 1e6 * progress.depot_wanted_m3)
                   : "\u2013");
    else
        number(columns[2], columns[3], y, flat ? "Target" : "To the target",
               off(1e3 * progress.to_target_m, " mm", 0));
    return y + (flat ? 12.0 : 58.0);
}

void GuidePanel::draw(const FrameState& seen) {
    const Progress& progress = seen.progress;
    const haptics::TickOutput& tick = seen.tick;
    canvas_->rectangle(0.0, 0.0, kWidth, height_, kPanelGlass);
    const bool finished = progress.step == Step::done;
    canvas_->text({kLeft, 48.0},
                  finished ? "Done"
                           : fmt::format("Step {} of {}", stepsBefore(progress, progress.step) + 1,
                                         stepsBefore(progress, Step::done)),
                  {.size = 34.0, .colour = kNext, .bold = true});
    drawSteps(progress);
    const report::TextStyle words{.size = kPrompt_px, .colour = kPanelText};
    // The reason for a refused step takes the place of the hint for a while.
    const bool refused = progress.refusal != training::Refusal::none &&
                         progress.elapsed_s - progress.refused_s < kRefusalShown_s;
    const training::Act act = nextAct(progress, tick, seen.equipment);
    if (act != act_ || now_s_ < act_since_s_) act_ = act, act_since_s_ = now_s_;
    const std::string verdict = answerVerdict(seen);
    const std::string prompt = !verdict.empty() ? verdict
                               : refused
                                   ? "Not done: " + std::string(training::refusalText(progress.refusal)) + "."
                               : rules_.next_step ? promptText()
                                                  : std::string(training::stepName(progress.step));
    double y = 88.0;
    for (const std::string& line : wrapped(*canvas_, prompt, words, kPromptWidth_px))
        canvas_->text({kLeft, y}, line, words), y += 34.0;

    y = rules_.next_step || refused || !verdict.empty() ? 164.0 : 130.0;  // a hint may have two lines
    y = drawNumbers(seen, y);
    const double last = height_ - 24.0, bottom = last - 44.0;
    if (haptics::isNeedleTool(tick.tool) && !seen.insertion.passed.empty())
        drawInsertion(seen, y, bottom);
    else
        drawCurve(y, bottom);
    const report::TextStyle foot{.size = 30.0, .colour = kPanelText, .bold = true};
    const std::array<double, 4> columns = numberColumns();
    canvas_->text({columns[0], last}, formatClock(progress.elapsed_s), foot);
    canvas_->text({columns[1] - 70.0, last}, "Breath " + std::string(breath_), foot);
    canvas_->text({columns[2], last}, "Score " + fmt::format("{:.0f}", progress.total), foot);
    canvas_->pixels(rgba_);
    ++revision_;
}

PanelPlace guidePlace(const Vec3& stage_entry_m, const Vec3& stage_eyes_m, double letter_rad) {
    const Vec3 corner = stage_entry_m + kCornerFromEntry_m;
    PanelPlace place;
    Vec3 middle = corner;
    // Iterate: the panel's width depends on the distance of its centre, and a wider panel has its centre
    // further away.
    for (int i = 0; i < kPlaceRounds; ++i) {
        place.width_m = std::min(kMaxWidth_m, GuidePanel::kWidth / GuidePanel::kLetter_px *
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
    if (eyes.z * point.z > 0.0) return false;  // eyes and point on the same side
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
