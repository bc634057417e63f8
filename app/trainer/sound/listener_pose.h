// Passes the pose of the user's head from the frame thread to the sound thread.
#pragma once

#include <mutex>
#include <optional>

#include "patient/patient.h"

namespace stylet::trainer {

// Pose in the drawn room. Any thread.
class ListenerPose {
  public:
    void store(const Pose& stage_from_head) {
        const std::lock_guard lock(mutex_);
        stage_from_head_ = stage_from_head;
    }
    std::optional<Pose> load() const {
        const std::lock_guard lock(mutex_);
        return stage_from_head_;
    }

  private:
    mutable std::mutex mutex_;
    std::optional<Pose> stage_from_head_;
};

}  // namespace stylet::trainer
