// Pain of the patient on the numeric scale from 0 to 10, in closed form. Derived from the ticks, never
// hashed.
//
// A stimulus of strength S at a place hurts S (1 - n), with the numbness n of that place
// (patient::Anaesthetic). The pain is that of the strongest stimulus, and each one fades to 1/e within
// kPainFade_s:
//   pain(t) = max over stimuli of S_i (1 - n_i) exp(-(t - t_i) / kPainFade_s)
// Strengths (own estimates; the order is that of reports on percutaneous biliary drainage, where dilatation
// hurts most): a needle through the skin 3, the scalpel 6, a needle through the liver's capsule 7, dilatation
// of the wall 8, a drain forced through a wall that no dilator has widened 10. The liver within its capsule
// does not hurt. The prick that brings the anaesthetic is a needle through the skin as well, so no drainage
// is free of pain.
//
// A drain that is forced ahead of the dilator tears the track, also in the numb wall and in the liver. Let l
// be the length of the track from the skin to the duct, and d the greatest depth that either tip has reached
// in this access. If the drain's tip then goes to a depth x, the torn length grows by max(0, min(x, l) - d).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "app/training/attempt_fold.h"

namespace stylet::training {

inline constexpr double kSkinPrick = 3.0, kIncisionPain = 6.0, kCapsulePain = 7.0, kDilatationPain = 8.0,
                        kTearPain = 10.0;
inline constexpr double kPainFade_s = 10.0;

struct PainEvent {
    double pain = 0.0;
    std::string_view cause;  // "the incision"
};

class Pain {
  public:
    // `patient` must outlive this object.
    Pain(const patient::Patient& patient, double dt_s) noexcept;

    // Session thread. Processes the next tick. No allocation.
    void update(const haptics::TickOutput&, const patient::Anaesthetic&) noexcept;
    double now() const noexcept { return now_; }
    double worst() const noexcept { return worst_; }
    double torn_m() const noexcept { return torn_m_; }  // length of the track that the drain tore
    // A stimulus of the newest tick that hurts more than the prick of a needle.
    std::optional<PainEvent> eventNow() const noexcept { return event_; }

  private:
    void hurt(double strength, double numbness, std::string_view cause) noexcept;
    void followNeedle(const haptics::TickOutput&, const patient::Anaesthetic&) noexcept;
    // Dilator and drain.
    void followTubes(const haptics::AccessStatus&, const patient::Anaesthetic&) noexcept;
    void widen(const haptics::AccessStatus&, const patient::Anaesthetic&, double depth_m, double strength,
               std::string_view cause) noexcept;

    const patient::Patient* patient_;
    double fade_;
    double now_ = 0.0, worst_ = 0.0;
    bool inside_ = false, in_liver_ = false;
    // The track's inner end, and the greatest depths that the dilator's tip, and either tip, have reached in
    // it.
    Vec3 base_m_{0.0};
    double dilated_m_ = 0.0, widened_m_ = 0.0;
    double torn_m_ = 0.0;
    std::string_view cause_;  // of the newest event, while it still acts, and its pain
    double reported_ = 0.0;
    std::optional<PainEvent> event_;
};

}  // namespace stylet::training
