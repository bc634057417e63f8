// The tissues that the needle has passed during an insertion, and the force in each depth step. Derived from
// the ticks; never felt or hashed.
#pragma once

#include <string>
#include <vector>

#include "haptics/loop/simulation.h"

namespace stylet::trainer {

// A tissue border that the tip has passed.
struct Passed {
    double depth_m = 0.0;  // along the track from the skin
    patient::Tissue tissue = patient::Tissue::air;
    patient::Role role = patient::Role::pass;
    std::string name;    // name of the labelled organ, else of the tissue
    double cut_n = 0.0;  // puncture force; 0: entered without a cut
};

// One insertion: from one puncture of the skin to the next.
struct Insertion {
    struct Felt {
        float depth_m = 0.0f, force_n = 0.0f;
    };
    std::vector<Passed> passed;  // shallowest first
    std::vector<Felt> felt;      // largest force in each depth step, down to the deepest point
};

// Session thread.
class InsertionLog {
  public:
    static constexpr double kStep_m = 0.0005, kDeepest_m = 0.25;
    static constexpr std::size_t kMaxPassed = 40;

    // The patient must outlive this object.
    explicit InsertionLog(const patient::Patient& patient) : patient_(&patient) {}
    // Call for every tick, in order.
    void update(const haptics::TickOutput&);
    // An event of the newest tick. If the needle is withdrawn and advanced again, it passes its borders a
    // second time.
    void update(const haptics::NeedleEvent&);
    // The current or last insertion; empty before the first.
    const Insertion& insertion() const { return insertion_; }

  private:
    const patient::Patient* patient_;
    Insertion insertion_;
    std::vector<Insertion::Felt> on_skin_;  // samples before the skin was punctured
    bool open_ = false;
};

}  // namespace stylet::trainer
