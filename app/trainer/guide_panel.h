// What a trainee may read beside the patient: step and hint, depth, force, tissue, breath, how far he is off
// the reference path, time and score, and of the insertion which tissues were passed how deep. One thread.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/seen.h"
#include "app/training/difficulty.h"

namespace stylet::trainer {

class GuidePanel {
  public:
    static constexpr int kWidth = 720, kHeight = 700;
    static constexpr int kLeastHeight = 440;    // of a flatter one, as wide
    static constexpr double kLetter_px = 26.0;  // an em of the smallest
    static constexpr double kEvery_s = 0.1;     // no more often is it drawn
    static constexpr double kCurve_s = 10.0;

    // In these pixels, of which it has as many across as it likes; one as flat as sizeIn() says.
    GuidePanel(const training::Hints&, double tick_s, int width_px = kWidth, int height_px = kHeight);
    // As large as it fits.
    static std::pair<int, int> sizeIn(int width_px, int height_px);
    // Drawn in another size from now on; what it keeps stays.
    void resize(int width_px, int height_px);
    // Keeps the curve; draws when the time has come and somebody looks.
    void take(const Seen&, bool looked_at);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }  // how often it was drawn
    void savePng(const std::filesystem::path& file) const { canvas_->savePng(file); }

  private:
    void draw(const Seen&);
    void drawSteps(const training::Progress&);
    // Between these heights.
    void drawCurve(double top, double bottom);
    void drawInsertion(const Seen&, double top, double bottom);
    void drawNames(const Insertion&, double top, double bottom, double full_m);
    void drawForceScale(double top, double bottom, double full_n);
    void number(double x, double y, const char* name, const std::string& value);

    training::Hints hints_;
    double tick_s_;
    std::optional<report::Canvas> canvas_;
    double height_ = kHeight;  // as it is drawn; the width is kWidth
    struct Sample {
        double t_s = 0.0, force_n = 0.0;
    };
    std::deque<Sample> curve_;
    double now_s_ = 0.0, drawn_s_ = 0.0, breath_v_ = 0.0;
    std::string_view breath_ = "";
    std::vector<report::Point> line_;
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

// What to do for a step, in a sentence.
std::string_view hintOf(training::Step) noexcept;

// Where it stands: beyond the table, toward the feet, turned to the operator. As wide as its
// letters need, within reason.
struct PanelPlace {
    patient::Pose stage_from_panel;  // its middle; seen from +z
    double width_m = 0.0, height_m = 0.0;
};
PanelPlace guidePlace(const patient::Vec3& stage_entry_m, const patient::Vec3& stage_eyes_m,
                      double letter_rad);
// It stands between the eyes and the point.
bool covers(const PanelPlace&, const patient::Vec3& stage_eyes_m, const patient::Vec3& stage_point_m);
// Some of it is within so many radians of the line of sight, seen from the front.
bool inView(const PanelPlace&, const patient::Pose& stage_from_head);

}  // namespace stylet::trainer
