// What the trainee sees at the border of his view, whatever he looks at: red stripes and a word while a
// structure at risk is struck, green dots when the target is reached. Colour, pattern and word say the same:
// one of them is enough. The middle of the view stays free. Frame thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/seen.h"

namespace stylet::trainer {

struct Alert {
    training::Struck struck = training::Struck::nothing;  // nothing: the target was reached
    friend bool operator==(const Alert&, const Alert&) = default;
};

// How long: one that is seen only for an instant is not seen.
inline constexpr double kAlertLeast_s = 0.5, kReached_s = 3.0;

class AlertWatch {
  public:
    explicit AlertWatch(double tick_s) : tick_s_(tick_s) {}
    // In the order of ticks; one from before leaves it as it is.
    std::optional<Alert> take(const Seen& seen) { return take(seen.tick.tick, seen.progress); }
    std::optional<Alert> take(std::uint64_t tick, const training::Progress&);

  private:
    double tick_s_;
    std::optional<double> struck_s_, reached_s_;  // seen last, seen first
    training::Struck struck_ = training::Struck::nothing;
    std::uint32_t hits_ = 0;
};

// The same for the light of the room, which comes and goes: red light is not to flash, and never more than
// three times a second (WCAG 2.3.1). Session thread.
inline constexpr double kGlowRise_s = 0.4, kGlowFall_s = 0.8;
class GlowWatch {
  public:
    explicit GlowWatch(double tick_s) : tick_s_(tick_s), alerts_(tick_s) {}
    // Every tick, in order.
    void take(std::uint64_t tick, const training::Progress&);
    const Glow& now() const { return now_; }

  private:
    double tick_s_;
    AlertWatch alerts_;
    Glow now_;
};
// What it makes of the light that comes from walls and floor: a factor for each colour.
patient::Vec3 shellLight(const Glow&);

// "STRUCK: VESSEL", "TARGET REACHED".
std::string alertWord(const Alert&);
report::Colour alertColour(const Alert&);
// Stripes or dots over a square of so many pixels, a stripe so wide, a dot in proportion.
inline constexpr double kStripe_px = 18.0;
void drawAlertPattern(report::Canvas&, const Alert&, double width, double height,
                      double stripe_px = kStripe_px);

// As a picture over the whole view: straight alpha, 0 in the middle.
class AlertPicture {
  public:
    static constexpr int kSize = 512;
    static constexpr double kFree = 0.80;  // of its width and height: nothing is drawn there
    // Draws when it is another one.
    void show(const Alert&);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }

  private:
    Alert shown_;
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

}  // namespace stylet::trainer
