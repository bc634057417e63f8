// The numbers of an attempt as they come: what the hand does and feels, what the frames take.
#pragma once

#include <deque>

#include "app/report/canvas.h"
#include "app/trainer/window/mirror_channels.h"

namespace stylet::trainer {

// One thread.
class Metrics {
  public:
    static constexpr double kWindow_s = 10.0;  // of the curves

    void take(const FrameSample&);
    // On all of a canvas of that size. Not `told`: without what an exam withholds.
    void draw(report::Canvas&, int width, int height, const StateGiven&, bool told = true) const;

  private:
    std::deque<FrameSample> samples_;  // of the last kWindow_s, in order
};

}  // namespace stylet::trainer
