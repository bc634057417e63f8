// Sound beside an attempt, on a thread of its own: a device may take its time to open, hang or go away, and
// nobody waits for it. Without one all goes on in silence.
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
    std::uint64_t begun = 0;     // sounds that began
    double late_s = 0.0;         // from hear() until the device had it: the latest of them,
    double mean_late_s = 0.0;    // and their mean
    double device_late_s = 0.0;  // as the device says
    std::string device;          // empty: there is none, or none any more
};

class Sounds {
  public:
    using Opened = std::function<Speaker()>;
    using Say = std::function<void(const std::string&)>;
    // `open` and `say` are called on the sound's thread. Who is where nobody says is where the operator is.
    Sounds(const patient::Pose& stage_from_operator, std::shared_ptr<const Ears>, Opened open, Say say);
    // Waits for the device no longer than a second.
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
