// The patient monitor's screen: the breath over the last seconds, its rate, and whether it is held.
#pragma once

#include <cstdint>
#include <vector>

#include "app/report/canvas.h"
#include "patient/signal.h"

namespace stylet::trainer {

// One thread.
class BreathMonitor {
  public:
    static constexpr int kWidth = 384, kHeight = 288;  // as the glass

    BreathMonitor();
    // What the patient does at `t_s`; a time before all that is shown begins anew. Draws about ten times a
    // second, and when a hold begins or ends.
    void take(double t_s, const patient::Surrogate&, bool held);

    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }  // another one: drawn anew

  private:
    struct Sample {
        double t_s = 0.0, v = 0.0;
    };
    double ratePerMinute() const;
    void draw();

    report::Canvas canvas_;
    std::vector<Sample> samples_;  // of the last kWindow_s, in order
    std::vector<std::uint8_t> rgba_;
    std::vector<report::Point> line_;
    std::uint64_t revision_ = 0;
    bool held_ = false;
};

}  // namespace stylet::trainer
