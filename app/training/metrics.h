// Metrics of an attempt, folded over its ticks; the input of the score. O(1) per tick, no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/training/attempt_fold.h"
#include "app/training/progress.h"
#include "app/training/score.h"
#include "app/training/surroundings.h"

namespace stylet::training {

// The reference path at the current breath. At the breath it was planned for, it is the planned line.
struct PathNow {
    Vec3 entry_m{0.0}, target_m{0.0};
    Vec3 axis{0.0, 0.0, 1.0};  // unit, into the body
};

// Quantities derived from one tick.
struct TickFacts {
    PathNow path;
    bool inside = false;  // needle in the body
    bool in_target = false;
    double clearance_m = 0.0, to_duct_m = 0.0;  // while `inside` (surroundings.h)
    Struck striking = Struck::nothing;
    double off_path_m = 0.0, off_angle_rad = 0.0, to_target_m = 0.0;
};

// A near miss: the tip comes closer than kNearMiss_m without striking. It is over once the tip is
// kNearMissOver_m away.
inline constexpr double kNearMiss_m = 0.002, kNearMissOver_m = 0.003;
// A portal branch runs beside every duct. Closer to the duct than this, risk structures count only if
// struck.
inline constexpr double kBesideDuct_m = 0.010;
// Half the thickness of the ultrasound beam.
inline constexpr double kHalfBeam_m = 0.0025;

class Metrics {
  public:
    Metrics(const patient::PlannedPath&, std::optional<Vec3> duct_along, double dt_s);

    // Session thread. Call for every tick, in order.
    void take(const haptics::TickOutput&, const TickFacts&, const AttemptFold&) noexcept;
    // Facts that are not in the ticks: the force at which a border was punctured; the puncture of the
    // target and its tick.
    void forceBeforeCut(double force_n) noexcept;
    void targetCut(const haptics::TickOutput&) noexcept;
    void steps(std::uint32_t done, std::uint32_t out_of_order) noexcept;

    MetricValues values() const noexcept;  // at the newest tick
    std::uint32_t riskHits() const noexcept;
    std::uint32_t nearMisses() const noexcept { return near_misses_; }
    // Events of the newest tick.
    bool struckNow() const noexcept { return struck_now_; }
    bool contactNow() const noexcept { return contact_now_; }
    std::optional<double> nearMissNow_m() const noexcept { return near_miss_now_m_; }

  private:
    void watchContacts(const haptics::TickOutput&) noexcept;
    void watchRisks(const TickFacts&) noexcept;
    void watchNearMiss(const TickFacts&) noexcept;
    void watchWay(const haptics::TickOutput&, const TickFacts&) noexcept;
    void watchPath(const haptics::TickOutput&, const TickFacts&) noexcept;

    double dt_s_, path_length_m_, path_v_;
    Vec3 entry_reference_m_;
    std::optional<Vec3> duct_along_;
    std::uint64_t ticks_ = 0, pause_ticks_ = 1;
    bool was_inside_ = false, ever_inside_ = false, struck_now_ = false, contact_now_ = false;
    std::optional<double> near_miss_now_m_;
    std::array<std::uint64_t, haptics::kToolCount> touched_tick_{};  // 0: never
    std::array<std::uint64_t, kStruckCount> struck_tick_{};
    std::array<std::uint32_t, kStruckCount> hits_{};
    std::uint32_t contacts_ = 0, near_misses_ = 0, steps_done_ = 0, out_of_order_ = 0;
    double near_grades_ = 0.0;
    bool near_ = false, near_struck_ = false;
    double near_least_m_ = 0.0;
    double no_go_s_ = 0.0, probe_s_ = 0.0;
    std::optional<Vec3> anchor_m_;
    double way_m_ = 0.0, way_breathing_m_ = 0.0, beam_m_ = 0.0,
           angle_rad_m_ = 0.0;  // the last two are integrals over the path
    std::optional<double> least_clearance_m_, entry_off_m_, capsule_v_, duct_angle_rad_, targeting_m_;
    double lateral_cut_m_ = 0.0, peak_force_n_ = 0.0;
    bool cut_ = false;
    DoseLedger dose_;
    double astray_m3_ = 0.0;
};

}  // namespace stylet::training
