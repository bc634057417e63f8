// The guide panel beside the patient. It shows step and hint, depth, force, tissue, breath, distance from the
// reference path, time and score. It also shows the tissues that this insertion has passed, with their
// depths. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/session/frame_state.h"
#include "app/training/difficulty.h"
#include "app/training/tutor.h"

namespace stylet::trainer {

class GuidePanel {
  public:
    static constexpr int kWidth = 720, kHeight = 700;
    static constexpr int kMinHeight = 440;      // height of the flat layout, which has the same width
    static constexpr double kLetter_px = 26.0;  // em of the smallest font
    // Em and width of a prompt, a hint or a refusal, for which there are two lines.
    static constexpr double kPrompt_px = 28.0, kPromptWidth_px = kWidth - 60.0;
    static constexpr double kEvery_s = 0.1;  // shortest time between redraws
    static constexpr double kCurve_s = 10.0;

    // Has the size kWidth x kHeight until it is resized.
    GuidePanel(const training::DifficultyRules&, const training::Controls&, double tick_s);
    // Returns the size of the largest panel that fits, possibly in the flat layout.
    static std::pair<int, int> sizeIn(int width_px, int height_px);
    // Changes the size, in pixels; any width. To fit a given area, use sizeIn(). The recorded curve is kept.
    void resize(int width_px, int height_px);
    // Records the force curve. Redraws only if `looked_at`, and at most every kEvery_s.
    void update(const FrameState&, bool looked_at);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }  // number of redraws
    void savePng(const std::filesystem::path& file) const { canvas_->savePng(file); }

  private:
    void draw(const FrameState&);
    std::string promptText() const;
    void drawSteps(const training::Progress&);
    bool isFlat() const;
    std::array<double, 4> numberColumns() const;
    // Heights are in layout pixels. Returns the height below the numbers.
    double drawNumbers(const FrameState&, double y);
    void drawCurve(double top, double bottom);
    void drawInsertion(const FrameState&, double top, double bottom);
    void drawNames(const Insertion&, double top, double bottom, double full_m);
    void drawForceScale(double top, double bottom, double full_n);
    // A value that is too wide for its column, which ends at `to_x`, gets smaller letters.
    void number(double x, double to_x, double y, const char* name, const std::string& value);

    training::DifficultyRules rules_;
    training::Controls controls_;
    double tick_s_;
    std::optional<report::Canvas> canvas_;
    double height_ = kHeight;  // layout height; the layout width is kWidth
    struct Sample {
        double t_s = 0.0, force_n = 0.0;
    };
    std::deque<Sample> curve_;
    training::Act act_ = training::Act::finish;
    double act_since_s_ = 0.0;
    double now_s_ = 0.0, drawn_s_ = 0.0, breath_v_ = 0.0;
    std::string_view breath_ = "";
    std::vector<report::Point> line_;
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

// The controls of an input device, by its name on the command line.
const training::Controls& controlsOf(const std::string& device);

// Placement of the panel: beyond the table, toward the feet, facing the operator. It is wide enough for
// legible letters, up to a limit.
struct PanelPlace {
    Pose stage_from_panel;  // panel centre; the front faces +z
    double width_m = 0.0, height_m = 0.0;
};
PanelPlace guidePlace(const Vec3& stage_entry_m, const Vec3& stage_eyes_m, double letter_rad);
// True if the panel lies between the eyes and the point.
bool covers(const PanelPlace&, const Vec3& stage_eyes_m, const Vec3& stage_point_m);
// True if some of the panel's front is within the field of view.
bool inView(const PanelPlace&, const Pose& stage_from_head);

}  // namespace stylet::trainer
