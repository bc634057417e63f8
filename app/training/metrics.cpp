#include "app/training/metrics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace stylet::training {

using haptics::TickOutput;
using haptics::Tool;

namespace {

constexpr double kDebounce_s = 0.25;  // a contact or hit repeated within this time counts once
constexpr double kTouch_n = 0.001;    // smallest force of a tool that touches the skin
// Parts of the procedure: the puncture and the drain count three times as much as another step. With these
// weights, an attempt with no step but those that a drain needs stays below the pass mark.
constexpr double kMainStep = 3.0, kOtherStep = 1.0, kCutBlindly = 1.0;
constexpr double kDegPerRad = 57.29577951308232, kMm = 1e3;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double weigh(std::uint32_t steps) noexcept {
    double sum = 0.0;
    for (int s = 0; s < kStepCount; ++s)
        if (contains(steps, Step(s)))
            sum += Step(s) == Step::advance || Step(s) == Step::drain ? kMainStep : kOtherStep;
    return sum;
}

double valueOr(const std::optional<double>& v, double unit) noexcept {
    return v ? *v * unit : kNone;
}

}  // namespace

Metrics::Metrics(const patient::PlannedPath& path, std::optional<Vec3> duct_axis, double dt_s)
    : dt_s_(dt_s),
      path_length_m_(glm::length(path.target_m - path.entry_m)),
      path_v_(path.breath.v),
      entry_reference_m_(path.entry_reference_m),
      duct_axis_(duct_axis),
      debounce_ticks_(std::uint64_t(std::max(1.0, std::floor(kDebounce_s / dt_s + 0.5)))) {}

void Metrics::update(const TickOutput& now, const TickFacts& facts, const AttemptFold& fold) noexcept {
    ++ticks_;
    struck_now_ = contact_now_ = false;
    near_miss_now_m_.reset();
    if (!facts.infiltrates) updateContacts(now);
    updateRiskHits(facts);
    updateNearMisses(facts);
    updateNeedleTravel(now, facts);
    updatePathMetrics(now, facts);
    for (std::size_t i = 0; i < kMetricCount; ++i)
        if (const auto next = kMetricTable[i].fold) folded_[i] = next(folded_[i], {now, facts, fold, dt_s_});
    was_inside_ = facts.inside;
}

void Metrics::updateContacts(const TickOutput& now) noexcept {
    const bool touches = haptics::pressesOnSkin(now.tool) ? glm::length(now.tool_force.force_n) > kTouch_n
                                                          : now.phase != haptics::Phase::outside;
    if (!touches) return;
    // A needle in the guide counts as the same tool as a free needle, and so do the tools that follow it.
    const Tool tool = haptics::pressesOnSkin(now.tool) ? now.tool : Tool::needle;
    std::uint64_t& last = touched_tick_[std::size_t(tool)];
    if (last == 0 || ticks_ - last > debounce_ticks_) {
        ++contacts_;
        contact_now_ = true;
    }
    last = ticks_;
}

void Metrics::updateRiskHits(const TickFacts& facts) noexcept {
    if (facts.current_risk == RiskStructure::nothing) return;
    std::uint64_t& last = struck_tick_[std::size_t(facts.current_risk)];
    if (last == 0 || ticks_ - last > debounce_ticks_) {
        ++hits_[std::size_t(facts.current_risk)];
        struck_now_ = true;
    }
    last = ticks_;
}

void Metrics::updateNearMisses(const TickFacts& facts) noexcept {
    const bool counts = facts.inside && facts.to_duct_m >= kBesideDuct_m;
    if (counts) min_clearance_m_ = std::min(min_clearance_m_.value_or(facts.clearance_m), facts.clearance_m);
    if (counts && !near_miss_active_ && facts.clearance_m < kNearMiss_m) {
        near_miss_active_ = true, near_miss_struck_ = false;
        near_miss_min_m_ = facts.clearance_m;
    }
    if (!near_miss_active_) return;
    near_miss_struck_ = near_miss_struck_ || facts.current_risk != RiskStructure::nothing;
    if (counts) near_miss_min_m_ = std::min(near_miss_min_m_, facts.clearance_m);
    if (counts && facts.clearance_m <= kNearMissOver_m) return;
    near_miss_active_ = false;
    if (near_miss_struck_) {
        near_miss_grades_ += 1.0;
        return;
    }
    ++near_misses_;
    near_miss_grades_ += 1.0 - near_miss_min_m_ / kNearMiss_m;
    near_miss_now_m_ = near_miss_min_m_;
}

void Metrics::updateNeedleTravel(const TickOutput& now, const TickFacts& facts) noexcept {
    if (!facts.inside || facts.infiltrates) {
        anchor_m_.reset();
        return;
    }
    const Vec3 tip_m = now.tip_reference_m;
    // Motion of the patient does not count as motion of the needle.
    if (!anchor_m_ || now.patient_moved_m != patient_moved_m_) anchor_m_ = tip_m;
    patient_moved_m_ = now.patient_moved_m;
    const double moved_m = glm::length(tip_m - *anchor_m_);
    if (!(moved_m >= kMinMotion_m)) return;
    travel_m_ += moved_m;
    if (!now.breath_held) travel_breathing_m_ += moved_m;
    // Averages are weighted by distance moved, so resting in a good position earns nothing.
    if (!target_cut_) {
        approach_m_ += moved_m;
        beam_m_ += moved_m * facts.in_beam;
        angle_rad_m_ += moved_m * facts.off_angle_rad;
    }
    anchor_m_ = tip_m;
}

void Metrics::updatePathMetrics(const TickOutput& now, const TickFacts& facts) noexcept {
    if (!facts.inside) return;
    ever_inside_ = true;
    if (!was_inside_ && !target_cut_) entry_off_m_ = glm::length(now.tip_reference_m - entry_reference_m_);
    if (!capsule_v_ && now.tissue == patient::Tissue::liver) capsule_v_ = std::fabs(now.breath.v - path_v_);
    if (target_cut_ && facts.in_target)
        targeting_m_ = std::min(targeting_m_.value_or(facts.to_target_m), facts.to_target_m);
}

void Metrics::recordPunctureForce(double force_n) noexcept {
    double& peak_n = folded_[std::size_t(MetricId::peakForce)];
    peak_n = std::max(peak_n, std::fabs(force_n));
}

void Metrics::recordTargetPuncture(const TickOutput& at) noexcept {
    if (target_cut_) return;
    target_cut_ = true;
    duct_angle_rad_ = 0.0;
    if (!duct_axis_) return;
    const double cosine = std::fabs(glm::dot(at.patient_from_needle.direction({0, 0, 1}), *duct_axis_));
    duct_angle_rad_ = std::acos(std::min(1.0, cosine));
}

void Metrics::setSteps(std::uint32_t of, std::uint32_t done, std::uint32_t out_of_order) noexcept {
    steps_ = of;
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
    MetricValues values = folded_;
    const auto put = [&](MetricId id, double value) { values[std::size_t(id)] = value; };
    const auto hits = [&](RiskStructure s) { return double(hits_[std::size_t(s)]); };
    double procedure = weigh(steps_done_);
    // The duct was cut, but not under ultrasound in a breath-hold.
    if (target_cut_ && !contains(steps_done_, Step::advance)) procedure += kCutBlindly;
    put(MetricId::procedure, 100.0 * procedure / weigh(steps_));
    put(MetricId::outOfOrder, out_of_order_);
    put(MetricId::targeting, valueOr(targeting_m_, kMm));
    put(MetricId::noGoTouches, riskHits());
    const bool advanced = approach_m_ > 0.0;
    put(MetricId::needleInBeam, advanced ? 100.0 * beam_m_ / approach_m_ : kNone);
    put(MetricId::sessionTime, double(ticks_) * dt_s_);
    put(MetricId::skinContacts, contacts_);
    put(MetricId::needlePath, ever_inside_ && path_length_m_ > 0.0 ? travel_m_ / path_length_m_ : kNone);
    put(MetricId::entryOff, valueOr(entry_off_m_, kMm));
    put(MetricId::angleOff, advanced ? kDegPerRad * angle_rad_m_ / approach_m_ : kNone);
    put(MetricId::vesselHits, hits(RiskStructure::vessel));
    put(MetricId::boneHits, hits(RiskStructure::bone));
    put(MetricId::lungHits, hits(RiskStructure::lung));
    put(MetricId::organHits, hits(RiskStructure::otherOrgan));
    put(MetricId::nearMisses,
        near_miss_grades_ + (!near_miss_active_  ? 0.0
                             : near_miss_struck_ ? 1.0
                                                 : 1.0 - near_miss_min_m_ / kNearMiss_m));
    put(MetricId::clearance, valueOr(min_clearance_m_, kMm));
    put(MetricId::ductAngle, valueOr(duct_angle_rad_, kDegPerRad));
    put(MetricId::breathAtCapsule, valueOr(capsule_v_, 1.0));
    put(MetricId::movedBreathing, travel_breathing_m_ * kMm);
    put(MetricId::caseReview, wrong_answers_);
    return values;
}

}  // namespace stylet::training
