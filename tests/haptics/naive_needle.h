// The axial force as the model's section 3 reads, in steps so small that nothing need be solved inside them:
// one tissue a step, one dimension, a still patient, no track. Slow; an oracle for ways in and out.
#pragma once

#include <vector>

#include "haptics/tools/needle.h"
#include "tests/haptics/column.h"

namespace stylet::test {

class NaiveNeedle {
  public:
    // Layers from x = 0; the needle begins inside the first, its spring relaxed.
    NaiveNeedle(const Layers&, const patient::TissueTable&, const haptics::NeedleSettings&);

    void to(double x_m);  // in steps of kStep_m
    double force() const;
    bool isHeld() const { return !holds_.empty(); }
    // How near a border or an event so far is to where the tip is now.
    double distanceToEvent() const;

    static constexpr double kStep_m = 1e-6;

  private:
    struct Border {
        double x_m = 0.0;
        patient::Tissue to = patient::Tissue::air;
    };
    struct Hold {
        double x_m = 0.0, a0_n = 0.0;  // where the tip was when it was met
        Border border;
    };
    const patient::TissueRow& row(patient::Tissue t) const { return table_[std::size_t(t)]; }
    patient::Tissue at(double x_m) const;
    bool behindHold() const { return !holds_.empty() && x_m_ >= holds_.back().x_m; }
    void forward(patient::Tissue);
    void backward(patient::Tissue);
    void meet(const Border&, bool queued_after);
    void enter(const Border&, double force_n, bool cut);
    void slide(double way_m);

    Layers layers_;
    patient::TissueTable table_;
    haptics::NeedleSettings settings_;
    long long step_ = 0;
    double x_m_ = 0.0, e_m_ = 0.0;
    patient::Tissue tissue_;
    std::vector<Hold> holds_;  // one, and bone on top of it
    std::vector<Border> queue_, cuts_;
    std::vector<double> events_m_;
};

}  // namespace stylet::test
