// Screen of the patient monitor: breathing trace of the last seconds, respiratory rate, breath hold, and
// pain.
#pragma once

#include <cstdint>
#include <vector>

#include "app/report/canvas.h"
#include "patient/motion/signal.h"

namespace stylet::trainer {

// Use from one thread only.
class BreathMonitor {
  public:
    static constexpr int kWidth = 384, kHeight = 288;

    BreathMonitor();
    // Adds the breath signal at `t_s`. A time before the oldest sample on the screen clears the trace.
    // Redraws about ten times per second, and when a breath hold begins or ends. `pain`: 0 to 10; none is not
    // shown.
    void update(double t_s, const patient::Surrogate&, bool held, double pain = 0.0);

    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }  // changes with every redraw

  private:
    struct Sample {
        double t_s = 0.0, v = 0.0;
    };
    double ratePerMinute() const;
    void draw();

    report::Canvas canvas_;
    std::vector<Sample> samples_;  // samples of the last kWindow_s, oldest first
    std::vector<std::uint8_t> rgba_;
    std::vector<report::Point> line_;
    std::uint64_t revision_ = 0;
    bool held_ = false;
    long pain_ = 0;
};

}  // namespace stylet::trainer
