// Plays an attempt's sounds on a thread of its own. A device may open slowly, hang or go away; nothing
// waits for it. Without a device the attempt continues in silence.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/trainer/sound/cues.h"
#include "app/trainer/sound/ears.h"
#include "app/trainer/sound/speaker.h"

namespace stylet::trainer {

struct SoundTotals {
    std::uint64_t begun = 0;     // sounds started
    double late_s = 0.0;         // latency from hear() to the device: maximum
    double mean_late_s = 0.0;    // and mean
    double device_late_s = 0.0;  // as reported by the device
    std::string device;          // empty: no device, or it was lost
};

class Sounds {
  public:
    using Opened = std::function<Speaker()>;
    using Say = std::function<void(const std::string&)>;
    // `open` and `say` are called on the sound thread. The listener is at `stage_from_operator` until the
    // head pose is known.
    Sounds(const Pose& stage_from_operator, std::shared_ptr<const Ears>, Opened open, Say say);
    // Waits at most one second for the device.
    ~Sounds();
    Sounds(const Sounds&) = delete;
    Sounds& operator=(const Sounds&) = delete;

    // Session thread, often. Returns at once.
    void hear(const Heard&);
    SoundTotals totals() const;

  private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
};

}  // namespace stylet::trainer
