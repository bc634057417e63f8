// What is written before the trainee's eyes while the attempt cannot go on as it is. Frame thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/pictures.h"

namespace stylet::trainer {

struct Notice {
    std::string title;
    std::vector<std::string> lines;
    friend bool operator==(const Notice&, const Notice&) = default;
};

// Nothing while all is well. `rearm_act` as in LiveHand; empty: nobody can re-arm.
std::optional<Notice> noticeOf(const Seen&, Attention, const std::string& rearm_act);

// Of a doubt that there is.
Notice noticeOf(RoomDoubt, const std::string& rearm_act);

// How large letters must be to be read: an em of kLeastText_rad, and of kLeastText_px in this headset.
inline constexpr double kLeastText_rad = 0.4 * 3.14159265358979 / 180.0, kLeastText_px = 20.0;
double letterAngle_rad(double px_per_rad);

// Words to lines of `width_px`.
std::vector<std::string> wrapped(report::Canvas&, const std::string& text, const report::TextStyle&,
                                 double width_px);

// The notice as a picture: dark glass, light letters.
class NoticePanel {
  public:
    static constexpr int kWidth = 768, kHeight = 300;
    static constexpr double kLetter_px = 34.0;  // an em of its lines

    NoticePanel();
    // Draws when it is another one.
    void show(const Notice&);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }
    // Its width at this distance for letters of that angle.
    static double width_m(double distance_m, double letter_rad);

  private:
    report::Canvas canvas_;
    Notice shown_;
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

}  // namespace stylet::trainer
