// Plays an attempt's sounds on its own thread. A device may open slowly, hang or be lost; no other thread
// waits for it. Without a device the attempt continues in silence.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/trainer/sound/cues.h"
#include "app/trainer/sound/listener_pose.h"
#include "app/trainer/sound/speaker.h"

namespace stylet::trainer {

struct SoundTotals {
    std::uint64_t begun = 0;     // sounds started
    double late_s = 0.0;         // latency from submit() to the device: largest
    double mean_late_s = 0.0;    // the same: mean
    double device_late_s = 0.0;  // the device's own latency, as it reports it
    std::string device;          // empty: no device, or it was lost
};

class Sounds {
  public:
    using Opened = std::function<Speaker()>;
    using Say = std::function<void(const std::string&)>;
    // `open` and `say` are called on the sound thread. The listener is at `stage_from_operator` until the
    // head pose is known.
    Sounds(const Pose& stage_from_operator, std::shared_ptr<const ListenerPose>, Opened open, Say say);
    // Waits at most one second for the device.
    ~Sounds();
    Sounds(const Sounds&) = delete;
    Sounds& operator=(const Sounds&) = delete;

    // Session thread, often. Returns at once.
    void submit(const SoundFrame&);
    SoundTotals totals() const;

  private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
};

}  // namespace stylet::trainer
