#include "render/frame/governor.h"

#include <algorithm>
#include <cmath>

namespace stylet::render {
namespace {

constexpr int kTwice = 2;  // one late frame may be the system's fault; two in a row are ours

}  // namespace

Governor::Governor(const GovernorSettings& settings) : settings_(settings) {}

void Governor::reportFrame(double volume_ms, double rest_ms, double drawn_scale) {
    if (!(volume_ms > 0.0) || !(rest_ms >= 0.0) || !std::isfinite(volume_ms + rest_ms)) return;
    const double room_ms = settings_.aimed * settings_.budget_ms - rest_ms;
    if (!(drawn_scale > 0.0) || room_ms <= 0.0) return;
    const double drawn = std::min(drawn_scale, double(scale_));
    // When the head is close, the layer is limited below the scale: a higher scale draws no more pixels.
    const double drawn_most = drawn < double(scale_) ? drawn : 1.0;
    // The number of rays, and with it their time, grows with the square of the scale.
    const auto fits = [&](float scale, double share) {
        const double ratio = std::min(double(scale), drawn_most) / drawn;
        return rest_ms + volume_ms * ratio * ratio <= share * settings_.budget_ms;
    };
    over_ = fits(scale_, 1.0) ? 0 : over_ + 1;
    const float higher = std::min(1.0f, scale_ + settings_.step);
    calm_ = fits(higher, settings_.aimed) ? calm_ + 1 : 0;
    if (over_ >= kTwice) {
        const double wanted = drawn * std::sqrt(room_ms / volume_ms);
        const auto steps = std::floor(float(wanted) / settings_.step);
        scale_ = std::clamp(steps * settings_.step, settings_.least, scale_);
        over_ = 0;
    } else if (calm_ >= settings_.patience) {
        scale_ = higher;
        calm_ = 0;
    }
}

}  // namespace stylet::render
