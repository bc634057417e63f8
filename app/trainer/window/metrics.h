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

    void add(const FrameSample&);
    // Fills a canvas of that size. Without `show_hidden`, omits everything that an exam hides.
    void draw(report::Canvas&, int width, int height, const StateUpdate&, bool show_hidden = true) const;

  private:
    std::deque<FrameSample> samples_;  // samples of the last kWindow_s, in order
};

}  // namespace stylet::trainer
