// Predicts the tool pose at the display time of a frame by extrapolating the newest pose of the haptics loop
// at constant velocity. The prediction error is measured once the true pose at that time is known.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/rings.h"
#include "haptics/loop/loop.h"

namespace stylet::trainer {

// Defaults chosen from the table of `stylet-bench --only xr.prediction`.
struct PredictionSettings {
    // Velocities are fitted over the newest samples in this window; 0: no prediction.
    double window_s = 0.016;
    double max_lead_s = 0.050;  // for a longer lead the prediction shrinks, to zero at twice this lead
    double max_travel_m = 0.020;
    double max_turn_rad = 0.35;
    // If there is no new device sample for this long, the tool is drawn at its last pose.
    double stale_s = 0.020;
};

// Difference between the tip drawn in a frame and the true tip at the frame's display time.
struct TipOffset {
    std::uint64_t frame = 0;
    double lead_s = 0.0;  // time from the newest sample to the display time
    double distance_m = 0.0, angle_rad = 0.0;
    // The difference as a time. > 0: the picture was ahead of the hand; < 0: behind it. Absent if the tip
    // hardly moved.
    std::optional<double> ahead_s;
};

// Frame thread only. No allocation. Times are on the haptics loop's clock.
class TipPredictor {
  public:
    explicit TipPredictor(const PredictionSettings& settings = {}) : settings_(settings) {}

    // Pops all samples from the ring. Call after reading the tick to be shown, so that the samples include
    // that tick. Call before at().
    void add(Ring<haptics::TipSample>&);
    void add(const haptics::TipSample&);

    // Returns the tick to draw at `display_ns`, with predicted tool, needle, parked probe and breath. Cuts,
    // phase and forces stay those of `newest`, so no cut is drawn before it happens. If the samples do not
    // cover the tick (a capture of the past, a gap), returns it unchanged.
    haptics::TickOutput at(const haptics::TickOutput& newest, std::int64_t display_ns) const;

    // Records a drawn tick, predicted or not, for a later measurement. If there are more than kMaxPending,
    // the oldest is dropped.
    void drew(std::uint64_t frame, std::int64_t display_ns, const haptics::TickOutput& drawn);
    // Returns the error of the next frame whose display time has passed, or nothing.
    std::optional<TipOffset> measured();

    static constexpr std::size_t kHistory = 128, kMaxPending = 16;

  private:
    struct Motion {
        Vec3 tip_m_s{0.0}, turn_rad_s{0.0}, probe_m_s{0.0};
    };
    struct Drawn {
        std::uint64_t frame = 0;
        std::int64_t display_ns = 0, sample_ns = 0;
        haptics::Tool tool = haptics::Tool::needle;
        Pose patient_from_tip;
    };
    const haptics::TipSample& recent(std::size_t back) const {
        return history_[(count_ - 1 - back) % kHistory];
    }
    Motion motion() const;
    Vec3 velocityBefore(const haptics::TipSample& after) const;
    void measure(const haptics::TipSample& before, const haptics::TipSample& after);

    PredictionSettings settings_;
    std::array<haptics::TipSample, kHistory> history_{};  // only samples with new device data
    std::size_t count_ = 0;                               // number of samples ever added
    haptics::TipSample newest_;                           // newest sample, with or without new device data
    bool any_ = false;
    std::array<Drawn, kMaxPending> pending_{};
    std::array<TipOffset, kMaxPending> measured_{};
    std::size_t pending_count_ = 0, measured_count_ = 0;
};

// Pose of the tool in use at a tick.
inline const Pose& activeToolPose(const haptics::TickOutput& tick) {
    return haptics::isNeedleTool(tick.tool) ? tick.patient_from_needle : tick.patient_from_tool;
}

}  // namespace stylet::trainer
