#include "app/trainer/view/prediction.h"
#include "base/rings.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace stylet::trainer {

using haptics::TickOutput;
using haptics::TipSample;

namespace {

// Sampling is not perfectly regular. A small tolerance keeps the last sample of the window.
constexpr double kWindowSlack = 1.05;
// Least number of samples for a velocity. If the window has fewer, older samples are used.
constexpr std::size_t kFewest = 2;
// After a longer gap in the samples (a pause, a full ring) the true pose is unknown.
constexpr double kGap_s = 0.050;
// Below this speed an offset is not converted to a time. The speed is measured over kSpeedOver_s.
constexpr double kMoves_m_s = 0.005, kSpeedOver_s = 0.015;
// If the drawn tick is older than the newest one by more than this, it is a capture of the past.
constexpr std::uint64_t kSameTicks = 100;

double secondsFrom(std::int64_t from_ns, std::int64_t to_ns) {
    return 1e-9 * double(to_ns - from_ns);
}

// Rotation vector: it points along the axis, and its length is the angle.
Vec3 rotationVector(Quat q) {
    if (q.w < 0.0) q = -q;
    const Vec3 v(q.x, q.y, q.z);
    const double sine = glm::length(v);
    return sine > 1e-12 ? v * (2.0 * std::atan2(sine, q.w) / sine) : 2.0 * v;
}

Quat turnedBy(const Vec3& rotation, const Quat& q) {
    const double angle = glm::length(rotation);
    return angle > 0.0 ? glm::angleAxis(angle, rotation / angle) * q : q;
}

Vec3 atMost(const Vec3& v, double most) {
    const double length = glm::length(v);
    return length > most ? v * (most / length) : v;
}

bool isSameTool(const TipSample& a, const TipSample& b) {
    return a.tool == b.tool && a.parked == b.parked;
}

}  // namespace

void TipPredictor::add(Ring<TipSample>& ring) {
    for (TipSample sample; ring.pop(sample);)
        add(sample);
}

void TipPredictor::add(const TipSample& sample) {
    if (any_) measure(newest_, sample);
    newest_ = sample;
    any_ = true;
    if (sample.fresh || count_ == 0) history_[count_++ % kHistory] = sample;
}

// Fits the velocity by least squares over the window, relative to the newest sample.
TipPredictor::Motion TipPredictor::motion() const {
    const TipSample& last = recent(0);
    double n = 0.0, sum_t = 0.0, sum_tt = 0.0;
    Vec3 tip(0.0), turn(0.0), probe(0.0), tip_t(0.0), turn_t(0.0), probe_t(0.0);
    for (std::size_t back = 0; back < std::min(count_, kHistory); ++back) {
        const TipSample& s = recent(back);
        const double t = secondsFrom(last.t_ns, s.t_ns);
        const bool in_window = -t <= kWindowSlack * settings_.window_s;
        const bool needed = back < kFewest && -t < settings_.stale_s;
        if ((!in_window && !needed) || !isSameTool(s, last)) break;
        const Vec3 d = s.patient_from_tip.position_m - last.patient_from_tip.position_m;
        const Vec3 r =
            rotationVector(s.patient_from_tip.rotation * glm::conjugate(last.patient_from_tip.rotation));
        const Vec3 p = s.probe_m - last.probe_m;
        n += 1.0, sum_t += t, sum_tt += t * t;
        tip += d, turn += r, probe += p;
        tip_t += t * d, turn_t += t * r, probe_t += t * p;
    }
    const double spread = n * sum_tt - sum_t * sum_t;
    if (!(spread > 0.0)) return {};
    return {(n * tip_t - sum_t * tip) / spread, (n * turn_t - sum_t * turn) / spread,
            (n * probe_t - sum_t * probe) / spread};
}

// Velocity measured over kSpeedOver_s, a time in which the error of one encoder count does not matter.
Vec3 TipPredictor::velocityBefore(const TipSample& after) const {
    for (std::size_t back = 0; back < std::min(count_, kHistory); ++back) {
        const TipSample& s = recent(back);
        const double t_s = secondsFrom(s.t_ns, after.t_ns);
        if (!isSameTool(s, after)) break;
        if (t_s >= kSpeedOver_s)
            return (after.patient_from_tip.position_m - s.patient_from_tip.position_m) / t_s;
    }
    return Vec3(0.0);
}

TickOutput TipPredictor::at(const TickOutput& newest, std::int64_t display_ns) const {
    TickOutput drawn = newest;
    if (settings_.window_s <= 0.0 || count_ == 0) return drawn;
    const TipSample& last = recent(0);
    const bool known = newest.tick <= newest_.tick && newest_.tick - newest.tick <= kSameTicks &&
                       newest.tool == last.tool && newest.probe_parked == last.parked;
    const double lead_s = secondsFrom(last.t_ns, display_ns);
    const double lasting_s = std::min(lead_s, std::max(0.0, 2.0 * settings_.max_lead_s - lead_s));
    if (!known || lasting_s <= 0.0) return drawn;
    drawn.breath.v += lasting_s * drawn.breath.rate_per_s;
    if (secondsFrom(last.t_ns, newest_.t_ns) > settings_.stale_s) return drawn;

    const Motion m = motion();
    const Vec3 travel_m = atMost(lasting_s * m.tip_m_s, settings_.max_travel_m);
    const Pose ahead{
        turnedBy(atMost(lasting_s * m.turn_rad_s, settings_.max_turn_rad), last.patient_from_tip.rotation),
        last.patient_from_tip.position_m + travel_m};
    if (haptics::isNeedleTool(newest.tool)) {
        const Vec3 inward = -ahead.direction(Vec3(0.0, 0.0, 1.0));
        if (newest.phase != haptics::Phase::outside)
            drawn.depth_m += glm::dot(ahead.position_m - newest.patient_from_needle.position_m, inward);
        drawn.patient_from_needle = ahead;
    } else {
        drawn.patient_from_tool = ahead;
    }
    if (newest.probe_parked)
        drawn.patient_from_probe.position_m =
            last.probe_m + atMost(lasting_s * m.probe_m_s, settings_.max_travel_m);
    return drawn;
}

void TipPredictor::drew(std::uint64_t frame, std::int64_t display_ns, const TickOutput& drawn) {
    if (!any_) return;
    if (pending_count_ == kMaxPending) {
        std::move(pending_.begin() + 1, pending_.end(), pending_.begin());
        --pending_count_;
    }
    pending_[pending_count_++] = {frame, display_ns, newest_.t_ns, drawn.tool, activeToolPose(drawn)};
}

// Measures the error of all drawn ticks whose display time lies between two samples of the true pose.
void TipPredictor::measure(const TipSample& before, const TipSample& after) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pending_count_; ++i) {
        const Drawn& d = pending_[i];
        if (d.display_ns > after.t_ns) {
            pending_[kept++] = d;
            continue;
        }
        // Nothing to compare: the true pose is unknown, or the tool has changed.
        const double between_s = secondsFrom(before.t_ns, after.t_ns);
        if (d.display_ns < before.t_ns || d.tool != after.tool || !isSameTool(before, after) ||
            between_s > kGap_s)
            continue;
        const double share = between_s > 0.0 ? secondsFrom(before.t_ns, d.display_ns) / between_s : 1.0;
        const Pose &a = before.patient_from_tip, &b = after.patient_from_tip;
        const Vec3 off_m = d.patient_from_tip.position_m - glm::mix(a.position_m, b.position_m, share);
        const Vec3 velocity_m_s = velocityBefore(after);
        const Quat truth = glm::slerp(a.rotation, b.rotation, share);
        TipOffset offset{d.frame, secondsFrom(d.sample_ns, d.display_ns), glm::length(off_m),
                         glm::length(rotationVector(d.patient_from_tip.rotation * glm::conjugate(truth))),
                         std::nullopt};
        const double speed2 = glm::dot(velocity_m_s, velocity_m_s);
        if (speed2 > kMoves_m_s * kMoves_m_s) offset.ahead_s = glm::dot(off_m, velocity_m_s) / speed2;
        if (measured_count_ < kMaxPending) measured_[measured_count_++] = offset;
    }
    pending_count_ = kept;
}

std::optional<TipOffset> TipPredictor::measured() {
    if (measured_count_ == 0) return std::nullopt;
    const TipOffset first = measured_[0];
    std::move(measured_.begin() + 1, measured_.begin() + std::ptrdiff_t(measured_count_), measured_.begin());
    --measured_count_;
    return first;
}

}  // namespace stylet::trainer
