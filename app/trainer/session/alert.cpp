#include "app/trainer/session/alert.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/common.hpp>

#include "base/smoothstep.h"

namespace stylet::trainer {
namespace {

using training::RiskStructure;

constexpr report::Colour kStruck{0.80, 0.05, 0.05}, kReached{0.02, 0.50, 0.18};
// Tint factors for the grey-green room: a dark red, and a green no brighter than the room without a tint.
constexpr Vec3 kStruckLight{1.50, 0.36, 0.32}, kReachedLight{0.50, 1.20, 0.62};
constexpr double kDotOfStripe = 13.0 / 18.0;
constexpr double kLetter_px = 24.0, kWordBaseline_px = 493.0, kPlateTop_px = 464.0;

// Returns 0 at the edge of the clear middle and 1 at the edge of the picture.
double outward(int x, int y) {
    const double half = 0.5 * AlertPicture::kSize;
    const double u = std::fabs((x + 0.5 - half) / half), v = std::fabs((y + 0.5 - half) / half);
    return std::clamp((std::max(u, v) - AlertPicture::kFree) / (1.0 - AlertPicture::kFree), 0.0, 1.0);
}

}  // namespace

std::string alertWord(const Alert& alert) {
    if (alert.struck == RiskStructure::nothing) return "TARGET REACHED";
    std::string word = "STRUCK: " + std::string(training::riskStructureName(alert.struck));
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::toupper(c); });
    return word;
}

report::Colour alertColour(const Alert& alert) {
    return alert.struck == RiskStructure::nothing ? kReached : kStruck;
}

void drawAlertPattern(report::Canvas& canvas, const Alert& alert, double width, double height,
                      double stripe_px) {
    constexpr report::Colour kLight{1.0, 1.0, 1.0, 0.35};
    if (alert.struck != RiskStructure::nothing) {
        for (double sum = 0.0; sum < width + height; sum += 2.0 * stripe_px)
            canvas.line({sum + stripe_px, -stripe_px}, {sum - height - stripe_px, height + stripe_px},
                        stripe_px / std::sqrt(2.0), kLight);
        return;
    }
    const double dot = kDotOfStripe * stripe_px;
    for (double y = dot; y < height; y += 2.0 * dot)
        for (double x = dot; x < width; x += 2.0 * dot)
            canvas.disc({x, y}, 0.55 * dot, kLight);
}

std::optional<Alert> AlertWatch::update(std::uint64_t tick, const training::Progress& now) {
    const double t_s = tick_s_ * double(tick);
    if (now.current_risk != RiskStructure::nothing) struck_ = now.current_risk, struck_s_ = t_s;
    if (now.risk_hits > hits_ &&
        now.current_risk == RiskStructure::nothing)  // struck and left again between two frames
        struck_ = now.last_risk, struck_s_ = t_s;
    hits_ = std::max(hits_, now.risk_hits);
    if (now.success && !reached_s_) reached_s_ = t_s;
    if (struck_s_ && t_s >= *struck_s_ && t_s - *struck_s_ < kMinAlert_s) return Alert{struck_};
    if (reached_s_ && t_s >= *reached_s_ && t_s - *reached_s_ < kReached_s) return Alert{};
    return std::nullopt;
}

void GlowWatch::update(std::uint64_t tick, const training::Progress& progress) {
    const std::optional<Alert> alert = alerts_.update(tick, progress);
    const auto follow = [&](float& level, bool lit) {
        level = std::clamp(level + float(lit ? tick_s_ / kGlowRise_s : -tick_s_ / kGlowFall_s), 0.0f, 1.0f);
    };
    follow(now_.struck, alert && alert->struck != RiskStructure::nothing);
    follow(now_.reached, alert && alert->struck == RiskStructure::nothing);
}

Vec3 shellLight(const Glow& glow) {
    const Vec3 reached = glm::mix(Vec3(1.0), kReachedLight, smoothStep(double(glow.reached)));
    return glm::mix(reached, kStruckLight, smoothStep(double(glow.struck)));
}

void AlertPicture::show(const Alert& alert) {
    if (revision_ > 0 && alert == shown_) return;
    shown_ = alert;
    const report::Colour colour = alertColour(alert);
    report::Canvas canvas(kSize, kSize, colour);
    drawAlertPattern(canvas, alert, kSize, kSize);
    const report::TextStyle style{
        .size = kLetter_px, .colour = {1.0, 1.0, 1.0}, .align = report::Align::centre, .bold = true};
    const std::string word = alertWord(alert);
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
