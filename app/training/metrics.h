// Metrics of an attempt, updated with every tick. They are the input of the score. O(1) per tick, no
// allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/training/attempt_fold.h"
#include "app/training/progress.h"
#include "app/training/score.h"
#include "app/training/surroundings.h"

namespace stylet::training {

// A near miss: the tip comes closer than kNearMiss_m without striking. It is over once the tip is
// kNearMissOver_m away.
inline constexpr double kNearMiss_m = 0.002, kNearMissOver_m = 0.003;
// A portal branch runs beside every duct. Within this distance of a duct, a risk structure counts only if the
// needle strikes it.
inline constexpr double kBesideDuct_m = 0.010;

class Metrics {
  public:
    Metrics(const patient::PlannedPath&, std::optional<Vec3> duct_axis, double dt_s);

    // Session thread. Call for every tick, in order.
    void update(const haptics::TickOutput&, const TickFacts&, const AttemptFold&) noexcept;
    // Facts that the ticks do not contain: the force at which a border was punctured, and the target's
    // puncture with its tick.
    void recordPunctureForce(double force_n) noexcept;
    void recordTargetPuncture(const haptics::TickOutput&) noexcept;
    void setSteps(std::uint32_t of, std::uint32_t done, std::uint32_t out_of_order) noexcept;
    void setWrongAnswers(int count) noexcept { wrong_answers_ = count; }  // to questions about the case

    MetricValues values() const noexcept;  // at the newest tick
    std::uint32_t riskHits() const noexcept;
    std::uint32_t nearMisses() const noexcept { return near_misses_; }
    // Events of the newest tick.
    bool riskHitNow() const noexcept { return struck_now_; }
    bool contactNow() const noexcept { return contact_now_; }
    std::optional<double> nearMissNow_m() const noexcept { return near_miss_now_m_; }

  private:
    void updateContacts(const haptics::TickOutput&) noexcept;
    void updateRiskHits(const TickFacts&) noexcept;
    void updateNearMisses(const TickFacts&) noexcept;
    void updateNeedleTravel(const haptics::TickOutput&, const TickFacts&) noexcept;
    void updatePathMetrics(const haptics::TickOutput&, const TickFacts&) noexcept;

    double dt_s_, path_length_m_, path_v_;
    Vec3 entry_reference_m_;
    std::optional<Vec3> duct_axis_;
    std::uint64_t ticks_ = 0, debounce_ticks_ = 1;
    bool was_inside_ = false, ever_inside_ = false, struck_now_ = false, contact_now_ = false;
    std::optional<double> near_miss_now_m_;
    std::array<std::uint64_t, haptics::kToolCount> touched_tick_{};  // 0: never
    std::array<std::uint64_t, kRiskStructureCount> struck_tick_{};
    std::array<std::uint32_t, kRiskStructureCount> hits_{};
    std::uint32_t steps_ = stepsOf(kDefaultCourse);
    int wrong_answers_ = 0;
    std::uint32_t contacts_ = 0, near_misses_ = 0, steps_done_ = 0, out_of_order_ = 0;
    double near_miss_grades_ = 0.0;
    bool near_miss_active_ = false, near_miss_struck_ = false;
    double near_miss_min_m_ = 0.0;
    std::optional<Vec3> anchor_m_;
    Vec3 patient_moved_m_{0.0};
    double travel_m_ = 0.0, travel_breathing_m_ = 0.0;
    // Until the target is cut: travel, and the integrals of beam share and angle over it.
    double approach_m_ = 0.0, beam_m_ = 0.0, angle_rad_m_ = 0.0;
    std::optional<double> min_clearance_m_, entry_off_m_, capsule_v_, duct_angle_rad_, targeting_m_;
    MetricValues folded_{};  // of the metrics with Metric::fold
    bool target_cut_ = false;
};

}  // namespace stylet::training
