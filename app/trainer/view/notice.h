// Notices shown to the trainee, at every difficulty: the attempt is paused, the force is off, the picture had
// stopped, a tool must be lifted, a rest is due, what the syringe drew and injected, what the expert cannot
// show, which request for this attempt was refused, or the case to review. Frame thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/view/pictures.h"
#include "app/training/tutor.h"

namespace stylet::trainer {

struct Notice {
    std::string title;
    std::vector<std::string> lines;
    bool tall = false;  // more lines than a usual notice
    friend bool operator==(const Notice&, const Notice&) = default;
};

// Returns nothing if there is nothing to report. `rearm_act`: how to re-arm the force (LiveHand); empty
// if no user could. `controls`: the words of the input that the trainee uses.
std::optional<Notice> makeNotice(const FrameState&, Attention, const std::string& rearm_act,
                                 const training::Controls& controls = training::kTypedControls);

// Notice for a warning other than RoomWarning::none.
Notice makeNotice(RoomWarning, const std::string& rearm_act);

// Minimum size of readable text: one em is at least kMinText_rad, and at least kMinText_px on the
// display.
inline constexpr double kMinText_rad = 0.4 * 3.14159265358979 / 180.0, kMinText_px = 20.0;
double letterAngle_rad(double px_per_rad);

// Breaks text at spaces into lines of at most `width_px`. A longer word is broken between its letters.
std::vector<std::string> wrapped(report::Canvas&, const std::string& text, const report::TextStyle&,
                                 double width_px);

// Renders a notice: light text on a dark background. Text that does not fit has smaller letters.
class NoticePanel {
  public:
    static constexpr int kWidth = 768, kHeight = 300, kTallHeight = 1080;
    static constexpr double kLetter_px = 34.0;  // em size of the lines
    static constexpr double kSmallest_px = 22.0;

    NoticePanel();
    // Redraws only if the notice changed.
    void show(const Notice&);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }
    int height() const { return shown_.tall ? kTallHeight : kHeight; }  // pixels, as shown
    // Rows from the top with text, and the lower margin. The rows below are transparent.
    int filledHeight() const { return filled_; }
    double letter_px() const { return letter_px_; }  // em size of the shown lines
    // Panel width at which one em spans `letter_rad` at this distance.
    static double width_m(double distance_m, double letter_rad);

  private:
    std::vector<std::string> breakLines(const std::vector<std::string>&);

    std::optional<report::Canvas> canvas_;
    Notice shown_;
    double letter_px_ = kLetter_px;
    int filled_ = 0;
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

}  // namespace stylet::trainer
