// Alerts at the edge of the trainee's view, visible in any gaze direction. Red stripes and a word: the tool
// strikes a risk structure. Green dots and a word: the target was reached. Colour, pattern and word carry the
// same message, so one of them is enough. The middle of the view stays free. Frame thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/session/frame_state.h"

namespace stylet::trainer {

struct Alert {
    training::RiskStructure struck = training::RiskStructure::nothing;  // `nothing`: the target was reached
    friend bool operator==(const Alert&, const Alert&) = default;
};

// A strike alert lasts kMinAlert_s beyond the last contact, so that a short strike is noticed too. The
// target alert lasts kReached_s.
inline constexpr double kMinAlert_s = 0.5, kReached_s = 3.0;

class AlertWatch {
  public:
    explicit AlertWatch(double tick_s) : tick_s_(tick_s) {}
    // Call in tick order. Returns the alert to show at this tick, or nothing.
    std::optional<Alert> update(const FrameState& seen) { return update(seen.tick.tick, seen.progress); }
    std::optional<Alert> update(std::uint64_t tick, const training::Progress&);

  private:
    double tick_s_;
    std::optional<double> struck_s_, reached_s_;  // last strike; first tick with the target reached
    training::RiskStructure struck_ = training::RiskStructure::nothing;
    std::uint32_t hits_ = 0;
};

// The same alerts as a tint of the room light, faded in and out. Red light must not flash more than three
// times a second (WCAG 2.3.1). Session thread.
inline constexpr double kGlowRise_s = 0.4, kGlowFall_s = 0.8;
class GlowWatch {
  public:
    explicit GlowWatch(double tick_s) : tick_s_(tick_s), alerts_(tick_s) {}
    // Call for every tick, in order.
    void update(std::uint64_t tick, const training::Progress&);
    const Glow& now() const { return now_; }

  private:
    double tick_s_;
    AlertWatch alerts_;
    Glow now_;
};
// Factor per colour channel for the light from walls and floor.
Vec3 shellLight(const Glow&);

// "STRUCK: VESSEL", "TARGET REACHED".
std::string alertWord(const Alert&);
report::Colour alertColour(const Alert&);
// Draws stripes (strike) or dots (target) over a rectangle of `width` x `height` pixels. The dot size is
// proportional to the stripe width.
inline constexpr double kStripe_px = 18.0;
void drawAlertPattern(report::Canvas&, const Alert&, double width, double height,
                      double stripe_px = kStripe_px);

// The alert as an overlay over the whole view. Straight alpha, 0 in the middle.
class AlertPicture {
  public:
    static constexpr int kSize = 512;
    static constexpr double kFree = 0.80;  // share of width and height that stays clear
    // Redraws only if the alert has changed.
    void show(const Alert&);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }

  private:
    Alert shown_;
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

}  // namespace stylet::trainer
