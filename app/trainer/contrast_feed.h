// The contrast medium's picture on its way from the session to the frames: only voxels that have changed, and
// neither side waits for the other's work.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "patient/patient.h"

namespace stylet::trainer {

class ContrastFeed {
  public:
    explicit ContrastFeed(const patient::ContrastTableSettings& settings = {}) : painter_(settings) {}

    // Session thread, often, where there are pictures. Costs nothing where nothing visible has changed.
    void give(const patient::Contrast&);
    // Frame thread: brings `table` up to date. True when it has changed. The lock is held to hand a list
    // over, never while it is made or applied.
    bool take(patient::ContrastTable& table);

  private:
    patient::ContrastPainter painter_;             // session thread
    patient::ContrastChanges changes_;             // its buffer
    std::vector<patient::ContrastChanges> taken_;  // frame thread's buffer
    std::mutex mutex_;
    std::vector<patient::ContrastChanges> waiting_;
};

}  // namespace stylet::trainer
