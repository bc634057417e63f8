#include "app/training/metrics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace stylet::training {

using haptics::TickOutput;
using haptics::Tool;

namespace {

constexpr double kPause_s = 0.25;      // a contact or hit repeated within this time counts once
constexpr double kTouch_n = 0.001;     // force of a tool that touches the skin
constexpr double kMovedBy_m = 0.0010;  // smaller motion is tremor (0.1 mm amplitude)
constexpr double kDegPerRad = 57.29577951308232, kMm = 1e3, kMl = 1e6, kGyCm2PerGyM2 = 1e4;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Share of the needle's length in the body that lies within the ultrasound beam.
double shareInBeam(const TickOutput& now) noexcept {
    const bool held = now.tool == Tool::probe && now.probe_touching_share > 0.0;
    if (!now.probe_parked && !held) return 0.0;
    const Pose patient_from_probe =
        now.probe_parked ? now.patient_from_probe : now.patient_from_tool * haptics::kStylusFromProbe;
    const Pose probe_from_needle = patient_from_probe.inverse() * now.patient_from_needle;
    const double tip = probe_from_needle.position_m.y;
    const double skin = (probe_from_needle * Vec3(0.0, 0.0, std::max(now.depth_m, 0.0))).y;
    const double low = std::min(tip, skin), high = std::max(tip, skin);
    if (high - low < 1e-6) return std::fabs(tip) <= kHalfBeam_m ? 1.0 : 0.0;
    return std::clamp((std::min(high, kHalfBeam_m) - std::max(low, -kHalfBeam_m)) / (high - low), 0.0, 1.0);
}

double valueOr(const std::optional<double>& v, double unit) noexcept {
    return v ? *v * unit : kNone;
}

}  // namespace

Metrics::Metrics(const patient::PlannedPath& path, std::optional<Vec3> duct_along, double dt_s)
    : dt_s_(dt_s),
      path_length_m_(glm::length(path.target_m - path.entry_m)),
      path_v_(path.breath.v),
      entry_reference_m_(path.entry_reference_m),
      duct_along_(duct_along),
      pause_ticks_(std::uint64_t(std::max(1.0, std::floor(kPause_s / dt_s + 0.5)))) {}

void Metrics::take(const TickOutput& now, const TickFacts& facts, const AttemptFold& fold) noexcept {
    ++ticks_;
    struck_now_ = contact_now_ = false;
    near_miss_now_m_.reset();
    watchContacts(now);
    watchRisks(facts);
    watchNearMiss(facts);
    watchWay(now, facts);
    watchPath(now, facts);
    if (now.tool == Tool::probe && now.probe_touching_share > 0.0) probe_s_ += dt_s_;
    lateral_cut_m_ = std::max(lateral_cut_m_, now.lateral_cut_m);
    peak_force_n_ = std::max(peak_force_n_, std::fabs(now.force_n));
    if (fold.begun()) {
        dose_ = fold.dose();
        astray_m3_ = std::max(0.0, dose_.contrast_m3 - fold.contrast().volumes().ducts_m3);
    }
    was_inside_ = facts.inside;
}

void Metrics::watchContacts(const TickOutput& now) noexcept {
    const bool touches = haptics::pressesOnSkin(now.tool) ? glm::length(now.tool_force.force_n) > kTouch_n
                                                          : now.phase != haptics::Phase::outside;
    if (!touches) return;
    // A needle in the guide counts as the same tool as a free needle.
    const Tool tool = haptics::holdsNeedle(now.tool) ? Tool::needle : now.tool;
    std::uint64_t& last = touched_tick_[std::size_t(tool)];
    if (last == 0 || ticks_ - last > pause_ticks_) {
        ++contacts_;
        contact_now_ = true;
    }
    last = ticks_;
}

void Metrics::watchRisks(const TickFacts& facts) noexcept {
    if (facts.striking == Struck::nothing) return;
    no_go_s_ += dt_s_;
    std::uint64_t& last = struck_tick_[std::size_t(facts.striking)];
    if (last == 0 || ticks_ - last > pause_ticks_) {
        ++hits_[std::size_t(facts.striking)];
        struck_now_ = true;
    }
    last = ticks_;
}

void Metrics::watchNearMiss(const TickFacts& facts) noexcept {
    const bool counts = facts.inside && facts.to_duct_m >= kBesideDuct_m;
    if (counts)
        least_clearance_m_ = std::min(least_clearance_m_.value_or(facts.clearance_m), facts.clearance_m);
    if (counts && !near_ && facts.clearance_m < kNearMiss_m) {
        near_ = true, near_struck_ = false;
        near_least_m_ = facts.clearance_m;
    }
    if (!near_) return;
    near_struck_ = near_struck_ || facts.striking != Struck::nothing;
    if (counts) near_least_m_ = std::min(near_least_m_, facts.clearance_m);
    if (counts && facts.clearance_m <= kNearMissOver_m) return;
    near_ = false;
    if (near_struck_) {
        near_grades_ += 1.0;
        return;
    }
    ++near_misses_;
    near_grades_ += 1.0 - near_least_m_ / kNearMiss_m;
    near_miss_now_m_ = near_least_m_;
}

void Metrics::watchWay(const TickOutput& now, const TickFacts& facts) noexcept {
    if (!facts.inside) {
        anchor_m_.reset();
        return;
    }
    const Vec3 tip_m = now.tip_reference_m;
    // Motion of the patient does not count as motion of the needle.
    if (!anchor_m_ || now.patient_moved_m != Vec3(0.0)) anchor_m_ = tip_m;
    const double moved_m = glm::length(tip_m - *anchor_m_);
    if (!(moved_m >= kMovedBy_m)) return;
    way_m_ += moved_m;
    if (!now.breath_held) way_breathing_m_ += moved_m;
    // Averages are weighted by distance moved, so resting in a good position earns nothing.
    beam_m_ += moved_m * shareInBeam(now);
    angle_rad_m_ += moved_m * facts.off_angle_rad;
    anchor_m_ = tip_m;
}

void Metrics::watchPath(const TickOutput& now, const TickFacts& facts) noexcept {
    if (!facts.inside) return;
    ever_inside_ = true;
    if (!was_inside_ && !cut_) entry_off_m_ = glm::length(now.tip_reference_m - entry_reference_m_);
    if (!capsule_v_ && now.tissue == patient::Tissue::liver) capsule_v_ = std::fabs(now.breath.v - path_v_);
    if (cut_ && facts.in_target)
        targeting_m_ = std::min(targeting_m_.value_or(facts.to_target_m), facts.to_target_m);
}

void Metrics::forceBeforeCut(double force_n) noexcept {
    peak_force_n_ = std::max(peak_force_n_, std::fabs(force_n));
}

void Metrics::targetCut(const TickOutput& at) noexcept {
    if (cut_) return;
    cut_ = true;
    duct_angle_rad_ = 0.0;
    if (!duct_along_) return;
    const double cosine = std::fabs(glm::dot(at.patient_from_needle.direction({0, 0, 1}), *duct_along_));
    duct_angle_rad_ = std::acos(std::min(1.0, cosine));
}

void Metrics::steps(std::uint32_t done, std::uint32_t out_of_order) noexcept {
    steps_done_ = done;
    out_of_order_ = out_of_order;
}

std::uint32_t Metrics::riskHits() const noexcept {
    std::uint32_t sum = 0;
    for (const std::uint32_t hits : hits_)
        sum += hits;
    return sum;
}

MetricValues Metrics::values() const noexcept {
    MetricValues values{};
    const auto put = [&](MetricId id, double value) { values[std::size_t(id)] = value; };
    const auto hits = [&](Struck s) { return double(hits_[std::size_t(s)]); };
    double procedure = 0.0;
    for (int s = 0; s < kStepCount; ++s)
        if ((steps_done_ & 1u << s) != 0) procedure += Step(s) == Step::advance ? 50.0 : 10.0;
    put(MetricId::procedure, procedure);
    put(MetricId::outOfOrder, out_of_order_);
    put(MetricId::targeting, valueOr(targeting_m_, kMm));
    put(MetricId::noGoTouches, riskHits());
    put(MetricId::noGoTime, no_go_s_);
    const bool advanced = way_m_ > 0.0;
    put(MetricId::needleInBeam, advanced ? 100.0 * beam_m_ / way_m_ : kNone);
    put(MetricId::probeTime, probe_s_);
    put(MetricId::sessionTime, double(ticks_) * dt_s_);
    put(MetricId::skinContacts, contacts_);
    put(MetricId::needlePath, ever_inside_ && path_length_m_ > 0.0 ? way_m_ / path_length_m_ : kNone);
    put(MetricId::entryOff, valueOr(entry_off_m_, kMm));
    put(MetricId::angleOff, advanced ? kDegPerRad * angle_rad_m_ / way_m_ : kNone);
    put(MetricId::vesselHits, hits(Struck::vessel));
    put(MetricId::boneHits, hits(Struck::bone));
    put(MetricId::lungHits, hits(Struck::lung));
    put(MetricId::organHits, hits(Struck::otherOrgan));
    put(MetricId::nearMisses, near_grades_ + (!near_         ? 0.0
                                              : near_struck_ ? 1.0
                                                             : 1.0 - near_least_m_ / kNearMiss_m));
    put(MetricId::clearance, valueOr(least_clearance_m_, kMm));
    put(MetricId::ductAngle, valueOr(duct_angle_rad_, kDegPerRad));
    put(MetricId::breathAtCapsule, valueOr(capsule_v_, 1.0));
    put(MetricId::movedBreathing, way_breathing_m_ * kMm);
    put(MetricId::lateralCut, lateral_cut_m_ * kMm);
    put(MetricId::fluoroscopy, dose_.fluoroscopy_s);
    put(MetricId::dose, dose_.dose_area_gy_m2 * kGyCm2PerGyM2);
    put(MetricId::contrast, dose_.contrast_m3 * kMl);
    put(MetricId::contrastAstray, astray_m3_ * kMl);
    put(MetricId::peakForce, peak_force_n_);
    return values;
}

}  // namespace stylet::training
