// Visible marks that the procedure leaves on the skin. Derived from the ticks, for pictures only; never felt
// or hashed.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/loop/simulation.h"

namespace stylet::trainer {

enum class WoundKind : std::uint8_t { incision, puncture, blood };

// A mark. It moves with the tissue.
struct Wound {
    WoundKind kind = WoundKind::puncture;
    Vec3 reference_m{0.0};
    double size_m = 0.0;        // radius; half the length of an incision
    Vec3 along{0.0, 0.0, 1.0};  // direction of an incision, or in which the blood runs
};

// Session thread.
class WoundLog {
  public:
    explicit WoundLog(double dt_s) : dt_s_(dt_s) {}
    // Radius of the holes that the needle makes from now on.
    void setNeedleRadius(double radius_m) { needle_radius_m_ = radius_m; }

    // Call for every tick, in order.
    void update(const haptics::TickOutput&);
    // A needle event at the newest tick. If it opened a vessel, the newest needle hole in the skin bleeds.
    void update(const haptics::NeedleEvent&);
    // The newest hole bleeds from now on. Returns false if there is no hole.
    bool bleed();
    // Wounds at the newest tick: incisions, then holes, then blood.
    std::vector<Wound> wounds() const;

  private:
    struct Hole {
        Vec3 reference_m{0.0};
        double radius_m = 0.0;
        bool bleeds = false;
        std::uint64_t opened_tick = 0;
    };
    double dt_s_;
    double needle_radius_m_ = NeedleShape().radius_m();
    std::uint64_t tick_ = 0;
    bool inside_ = false;
    std::vector<haptics::Incision> incisions_;
    std::vector<Hole> holes_;
};

}  // namespace stylet::trainer
