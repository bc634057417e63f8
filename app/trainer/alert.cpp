#include "app/trainer/alert.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "app/report/canvas.h"

namespace stylet::trainer {
namespace {

using training::Struck;

constexpr report::Colour kStruck{0.80, 0.05, 0.05}, kReached{0.02, 0.50, 0.18};
constexpr double kStripe_px = 18.0, kDot_px = 13.0;
constexpr double kLetter_px = 24.0, kWordBaseline_px = 493.0, kPlateTop_px = 464.0;

std::string wordOf(const Alert& alert) {
    if (alert.struck == Struck::nothing) return "TARGET REACHED";
    std::string word = "STRUCK: " + std::string(training::struckName(alert.struck));
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::toupper(c); });
    return word;
}

// 0 at the border of the free middle, 1 at the picture's own.
double outward(int x, int y) {
    const double half = 0.5 * AlertPicture::kSize;
    const double u = std::fabs((x + 0.5 - half) / half), v = std::fabs((y + 0.5 - half) / half);
    return std::clamp((std::max(u, v) - AlertPicture::kFree) / (1.0 - AlertPicture::kFree), 0.0, 1.0);
}

void drawPattern(report::Canvas& canvas, const Alert& alert) {
    constexpr report::Colour kLight{1.0, 1.0, 1.0, 0.35};
    constexpr double kSize = AlertPicture::kSize;
    if (alert.struck != Struck::nothing) {
        for (double sum = 0.0; sum < 2.0 * kSize; sum += 2.0 * kStripe_px)
            canvas.line({sum + kStripe_px, -kStripe_px}, {sum - kSize - kStripe_px, kSize + kStripe_px},
                        kStripe_px / std::sqrt(2.0), kLight);
        return;
    }
    for (double y = kDot_px; y < kSize; y += 2.0 * kDot_px)
        for (double x = kDot_px; x < kSize; x += 2.0 * kDot_px)
            canvas.disc({x, y}, 0.55 * kDot_px, kLight);
}

}  // namespace

std::optional<Alert> AlertWatch::take(const Seen& seen) {
    const training::Progress& now = seen.progress;
    const double t_s = tick_s_ * double(seen.tick.tick);
    if (now.striking != Struck::nothing) struck_ = now.striking, struck_s_ = t_s;
    if (now.risk_hits > hits_ && now.striking == Struck::nothing)  // between two frames
        struck_ = now.last_struck, struck_s_ = t_s;
    hits_ = std::max(hits_, now.risk_hits);
    if (now.success && !reached_s_) reached_s_ = t_s;
    if (struck_s_ && t_s >= *struck_s_ && t_s - *struck_s_ < kAlertLeast_s) return Alert{struck_};
    if (reached_s_ && t_s >= *reached_s_ && t_s - *reached_s_ < kReached_s) return Alert{};
    return std::nullopt;
}

void AlertPicture::show(const Alert& alert) {
    if (revision_ > 0 && alert == shown_) return;
    shown_ = alert;
    const report::Colour colour = alert.struck == Struck::nothing ? kReached : kStruck;
    report::Canvas canvas(kSize, kSize, colour);
    drawPattern(canvas, alert);
    const report::TextStyle style{
        .size = kLetter_px, .colour = {1.0, 1.0, 1.0}, .align = report::Align::centre, .bold = true};
    const std::string word = wordOf(alert);
    const double half = 0.5 * canvas.textWidth(word, style) + 16.0;
    canvas.rectangle(0.5 * kSize - half, kPlateTop_px, 2.0 * half, kSize - kPlateTop_px - 8.0, colour);
    canvas.text({0.5 * kSize, kWordBaseline_px}, word, style);
    canvas.pixels(rgba_);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const bool plate =
                y >= int(kPlateTop_px) && y < kSize - 8 && std::fabs(x + 0.5 - 0.5 * kSize) < half;
            const double alpha = plate ? 0.95 : 0.75 * std::sqrt(outward(x, y));
            rgba_[4 * std::size_t(y * kSize + x) + 3] = std::uint8_t(std::lround(255.0 * alpha));
        }
    ++revision_;
}

}  // namespace stylet::trainer
