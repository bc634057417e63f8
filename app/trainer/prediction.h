// What the hand holds, drawn where it will be when the picture is seen: the newest pose of the haptics loop
// is taken ahead at constant velocity, and how far that was from the truth is measured once the truth is
// known.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "haptics/loop.h"

namespace stylet::trainer {

// Defaults from the table of `stylet-bench --only xr.prediction`.
struct PredictionSettings {
    double window_s = 0.016;     // velocities are fitted over the newest so much; 0: nothing is taken ahead
    double most_lead_s = 0.050;  // beyond it less and less: the stream has ended, or nobody could know
    double most_way_m = 0.020;
    double most_turn_rad = 0.35;
    double stale_s = 0.020;  // nothing new from the device for so long: it is drawn where it was
};

// How far a frame's tip was from where it really was at the frame's display time.
struct TipOffset {
    std::uint64_t frame = 0;
    double lead_s = 0.0;  // from the newest sample to the display time
    double distance_m = 0.0, angle_rad = 0.0;
    // The same as time, where the tip moved: the picture was ahead of the hand by so much, or behind (< 0).
    std::optional<double> ahead_s;
};

// Frame thread only, and no allocation. Times are the loop's clock.
class TipPredictor {
  public:
    explicit TipPredictor(const PredictionSettings& settings = {}) : settings_(settings) {}

    // Empties the ring. Before at(), and after the tick shown was read: it is then among the samples.
    void take(haptics::Ring<haptics::TipSample>&);
    void take(const haptics::TipSample&);

    // The tick as it is to be drawn at `display_ns`: tool, needle, parked probe and breath taken ahead. What
    // happened (cuts, phase, forces) is the tick's own: nothing is drawn cut before it is. As it is, where
    // the stream knows nothing of it: a moment of the past, a lost stretch.
    haptics::TickOutput at(const haptics::TickOutput& newest, std::int64_t display_ns) const;

    // What was drawn, to be measured; at() or not. The oldest is forgotten beyond kMostPending.
    void drew(std::uint64_t frame, std::int64_t display_ns, const haptics::TickOutput& drawn);
    // The next frame whose display time has passed.
    std::optional<TipOffset> measured();

    static constexpr std::size_t kHistory = 128, kMostPending = 16;

  private:
    struct Motion {
        patient::Vec3 tip_m_s{0.0}, turn_rad_s{0.0}, probe_m_s{0.0};
    };
    struct Drawn {
        std::uint64_t frame = 0;
        std::int64_t display_ns = 0, sample_ns = 0;
        haptics::Tool tool = haptics::Tool::needle;
        patient::Pose patient_from_tip;
    };
    const haptics::TipSample& recent(std::size_t back) const {
        return history_[(count_ - 1 - back) % kHistory];
    }
    Motion motion() const;
    patient::Vec3 velocityBefore(const haptics::TipSample& after) const;
    void measure(const haptics::TipSample& before, const haptics::TipSample& after);

    PredictionSettings settings_;
    std::array<haptics::TipSample, kHistory> history_{};  // where the device said something new
    std::size_t count_ = 0;                               // ever
    haptics::TipSample newest_;                           // also without anything new
    bool any_ = false;
    std::array<Drawn, kMostPending> pending_{};
    std::array<TipOffset, kMostPending> measured_{};
    std::size_t pending_count_ = 0, measured_count_ = 0;
};

// The pose that the hand of a tick shows.
inline const patient::Pose& tipOf(const haptics::TickOutput& tick) {
    return haptics::holdsNeedle(tick.tool) ? tick.patient_from_needle : tick.patient_from_tool;
}

}  // namespace stylet::trainer
