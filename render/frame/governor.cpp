#include "render/frame/governor.h"

#include <algorithm>
#include <cmath>

namespace stylet::render {
namespace {

constexpr int kLateFrames = 2;  // in a row before the resolution drops; other load may cause a single one

}  // namespace

Governor::Governor(const GovernorSettings& settings) : settings_(settings) {}

void Governor::reportFrame(double volume_ms, double other_ms, double drawn_scale) {
    if (!(volume_ms > 0.0) || !(other_ms >= 0.0) || !std::isfinite(volume_ms + other_ms)) return;
    const double room_ms = settings_.target_share * settings_.budget_ms - other_ms;
    if (!(drawn_scale > 0.0) || room_ms <= 0.0) return;
    const double drawn = std::min(drawn_scale, double(scale_));
    // When the head is close, `close_up` limits the layer's resolution, and a higher scale draws no more
    // pixels.
    const double max_drawn = drawn < double(scale_) ? drawn : 1.0;
    // The number of rays, and with it their time, grows with the square of the scale.
    const auto fits = [&](float scale, double share) {
        const double ratio = std::min(double(scale), max_drawn) / drawn;
        return other_ms + volume_ms * ratio * ratio <= share * settings_.budget_ms;
    };
    frames_over_budget_ = fits(scale_, 1.0) ? 0 : frames_over_budget_ + 1;
    const float higher = std::min(1.0f, scale_ + settings_.step);
    frames_with_headroom_ = fits(higher, settings_.target_share) ? frames_with_headroom_ + 1 : 0;
    if (frames_over_budget_ >= kLateFrames) {
        const double wanted = drawn * std::sqrt(room_ms / volume_ms);
        const auto steps = std::floor(float(wanted) / settings_.step);
        scale_ = std::clamp(steps * settings_.step, settings_.min_scale, scale_);
        frames_over_budget_ = 0;
    } else if (frames_with_headroom_ >= settings_.patience) {
        scale_ = higher;
        frames_with_headroom_ = 0;
    }
}

}  // namespace stylet::render
