// Pain of the patient on the numeric scale from 0 to 10, in closed form. Derived from the ticks, never
// hashed.
//
// A stimulus of strength S at a place hurts S (1 - n), with the numbness n of that place
// (patient::Anaesthetic). The pain is that of the strongest stimulus, and each one fades to 1/e within
// kPainFade_s:
//   pain(t) = max over stimuli of S_i (1 - n_i) exp(-(t - t_i) / kPainFade_s)
// Strengths (own estimates; the order is that of reports on percutaneous biliary drainage, where dilatation
// hurts most): a needle through the skin 3, the scalpel 6, a needle through the liver's capsule 7, dilatation
// of the wall 8. The liver within its capsule does not hurt. The prick that brings the anaesthetic is a
// needle through the skin as well, so no drainage is free of pain.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "app/training/attempt_fold.h"

namespace stylet::training {

inline constexpr double kSkinPrick = 3.0, kIncisionPain = 6.0, kCapsulePain = 7.0, kDilatationPain = 8.0;
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
    // A stimulus of the newest tick that hurts more than the prick of a needle.
    std::optional<PainEvent> eventNow() const noexcept { return event_; }

  private:
    void hurt(double strength, double numbness, std::string_view cause) noexcept;
    void followNeedle(const haptics::TickOutput&, const patient::Anaesthetic&) noexcept;
    void followDilator(const haptics::TickOutput&, const patient::Anaesthetic&) noexcept;

    const patient::Patient* patient_;
    double fade_;
    double now_ = 0.0, worst_ = 0.0;
    bool inside_ = false, in_liver_ = false;
    double widened_m_ = 0.0;  // depth that the dilator's tip has reached
    std::string_view cause_;  // of the newest event, while it still acts, and its pain
    double reported_ = 0.0;
    std::optional<PainEvent> event_;
};

}  // namespace stylet::training
