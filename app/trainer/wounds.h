// What the procedure has left on the skin, for the picture: found by watching the ticks, never felt or
// hashed.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/simulation.h"

namespace stylet::trainer {

enum class WoundKind : std::uint8_t { incision, puncture, blood };

// Fixed to the tissue.
struct Wound {
    WoundKind kind = WoundKind::puncture;
    patient::Vec3 reference_m{0.0};
    double size_m = 0.0;                 // radius; of an incision half its length
    patient::Vec3 along{0.0, 0.0, 1.0};  // of an incision; where blood runs to
};

// Session thread.
class WoundLog {
  public:
    explicit WoundLog(double dt_s) : dt_s_(dt_s) {}

    // Every tick, in order.
    void take(const haptics::TickOutput&);
    // A cut at the newest tick: where a vessel was opened, the needle's hole in the skin bleeds.
    void take(const haptics::NeedleEvent&);
    // The newest hole bleeds from now on; false where there is none.
    bool bleed();
    // As they are at the newest tick: incisions, then holes, then blood.
    std::vector<Wound> wounds() const;

  private:
    struct Hole {
        patient::Vec3 reference_m{0.0};
        bool bleeds = false;
        std::uint64_t opened_tick = 0;
    };
    double dt_s_;
    std::uint64_t tick_ = 0;
    bool inside_ = false;
    std::vector<haptics::Incision> incisions_;
    std::vector<Hole> holes_;
};

}  // namespace stylet::trainer
