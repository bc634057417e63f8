// Axial needle force, implemented literally from section 3 of the model. Steps are so small that each
// crosses at most one border and nothing has to be solved within a step. One dimension, patient at rest, no
// needle track. Slow; a test oracle for insertion and withdrawal.
#pragma once

#include <vector>

#include "haptics/tools/needle.h"
#include "tests/haptics/column.h"

namespace stylet::test {

class NaiveNeedle {
  public:
    // Layers start at x = 0. The needle starts inside the first layer with its spring relaxed.
    NaiveNeedle(const Layers&, const patient::TissueTable&, const haptics::NeedleSettings&);

    void to(double x_m);  // moves in steps of kStep_m
    double force() const;
    bool isTenting() const { return !tenting_.empty(); }
    // Distance from the tip to the nearest border or past event.
    double distanceToEvent() const;

    static constexpr double kStep_m = 1e-6;

  private:
    struct Border {
        double x_m = 0.0;
        patient::Tissue to = patient::Tissue::air;
    };
    struct TentingBorder {
        double x_m = 0.0, a0_n = 0.0;  // tip position and force when the border was reached
        Border border;
    };
    const patient::TissueRow& row(patient::Tissue t) const { return table_[std::size_t(t)]; }
    patient::Tissue at(double x_m) const;
    bool isTentingAtTip() const { return !tenting_.empty() && x_m_ >= tenting_.back().x_m; }
    void forward(patient::Tissue);
    void backward(patient::Tissue);
    void meet(const Border&, bool queued_after);
    void enter(const Border&, double force_n, bool cut);
    void slide(double travel_m);

    Layers layers_;
    patient::TissueTable table_;
    haptics::NeedleSettings settings_;
    long long step_ = 0;
    double x_m_ = 0.0, e_m_ = 0.0;
    patient::Tissue tissue_;
    std::vector<TentingBorder> tenting_;  // one border, and possibly bone on top of it
    std::vector<Border> queue_, cuts_;
    std::vector<double> events_m_;
};

}  // namespace stylet::test
