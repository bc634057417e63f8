// Transfers the picture of the contrast medium from the session thread to the frame thread. Only changed
// voxels are sent, and neither thread waits for the other's work.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "patient/patient.h"

namespace stylet::trainer {

class ContrastFeed {
  public:
    explicit ContrastFeed(const patient::ContrastTableSettings& settings = {}) : painter_(settings) {}

    // Session thread. Call often if pictures are drawn. It is cheap if nothing visible has changed.
    void publish(const patient::Contrast&);
    // Frame thread. Brings `table` up to date and returns true if it changed. The lock is held only while
    // lists are exchanged, never while they are built or applied.
    bool applyTo(patient::ContrastTable& table);

  private:
    patient::ContrastPainter painter_;              // session thread
    patient::ContrastChanges changes_;              // session thread's buffer
    std::vector<patient::ContrastChanges> popped_;  // frame thread's buffer
    std::mutex mutex_;
    std::vector<patient::ContrastChanges> waiting_;
};

}  // namespace stylet::trainer
