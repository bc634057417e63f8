// Live numbers of an attempt: the state of the tool, the force and the frame times.
#pragma once

#include <deque>

#include "app/report/canvas.h"
#include "app/trainer/window/mirror_channels.h"

namespace stylet::trainer {

// Use from one thread only.
class Metrics {
  public:
    static constexpr double kWindow_s = 10.0;  // time span of the curves

    void take(const FrameSample&);
    // Fills a canvas of that size. If `told` is false, leaves out what an exam withholds.
    void draw(report::Canvas&, int width, int height, const StateGiven&, bool told = true) const;

  private:
    std::deque<FrameSample> samples_;  // of the last kWindow_s, in order
};

}  // namespace stylet::trainer
