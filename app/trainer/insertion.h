// What the needle has passed on its way in, and how hard it was pushed there: found by watching the ticks,
// never felt or hashed.
#pragma once

#include <string>
#include <vector>

#include "haptics/simulation.h"

namespace stylet::trainer {

// A border behind the tip, or that was.
struct Passed {
    double depth_m = 0.0;  // along the track from the skin
    patient::Tissue tissue = patient::Tissue::air;
    patient::Role role = patient::Role::pass;
    std::string name;    // of the organ where the CT has it, else of the tissue
    double cut_n = 0.0;  // what it took; 0: it was entered without a cut
};

// One insertion: from where the skin gave way until the next time it does.
struct Insertion {
    struct Felt {
        float depth_m = 0.0f, force_n = 0.0f;
    };
    std::vector<Passed> passed;  // the shallowest first
    std::vector<Felt> felt;      // the largest force of each step of the way in, as deep as it ever was
};

// Session thread.
class InsertionLog {
  public:
    static constexpr double kStep_m = 0.0005, kDeepest_m = 0.25;
    static constexpr std::size_t kMostPassed = 40;

    // The patient must outlive it.
    explicit InsertionLog(const patient::Patient& patient) : patient_(&patient) {}
    // Every tick, in order.
    void take(const haptics::TickOutput&);
    // Of the newest tick. Who is drawn back and advances again passes what he passes anew.
    void take(const haptics::NeedleEvent&);
    // The last one, under way or over; empty before the first.
    const Insertion& insertion() const { return insertion_; }

  private:
    const patient::Patient* patient_;
    Insertion insertion_;
    std::vector<Insertion::Felt> on_skin_;  // before it gave way
    bool open_ = false;
};

}  // namespace stylet::trainer
