#include "app/trainer/window/slice_view.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "app/trainer/view/access_tubes.h"
#include "app/trainer/view/prediction.h"

namespace stylet::trainer {

using report::Colour;

namespace {

constexpr double kShown_m = 0.13;    // shorter edge of a slice
constexpr double kMaxBeside = 0.25;  // largest offset of the tip from the middle, as a fraction of kShown_m
constexpr double kHandle_m = 0.15;   // of a tool without a shaft
constexpr int kCoarse = 2;           // window pixels per slice sample
constexpr Colour kDark{0.05, 0.06, 0.07}, kWhite{0.94, 0.95, 0.96}, kTool{0.35, 0.90, 1.0},
    kCross{1.0, 0.85, 0.35};

struct Way {
    const char* title;
    Vec3 right, down;
    const char *left_letter, *right_letter, *top_letter, *bottom_letter;
};
// Viewing directions as in radiology: from the feet, from the front, from the left.
const std::array<Way, 3> kWays{{{"axial", {-1, 0, 0}, {0, -1, 0}, "R", "L", "A", "P"},
                                {"coronal", {-1, 0, 0}, {0, 0, -1}, "R", "L", "H", "F"},
                                {"sagittal", {0, -1, 0}, {0, 0, -1}, "A", "P", "H", "F"}}};

}  // namespace

report::Point SliceView::Cell::pixelOf(const Vec3& p_m) const {
    const Vec3 d = (p_m - plane.centre_m) / m_per_pixel;
    return {rect.x + 0.5 * rect.width + glm::dot(d, plane.right),
            rect.y + 0.5 * rect.height + glm::dot(d, plane.down)};
}

void SliceView::place(int width, int height, const Vec3& tip_m) {
    const Vec3 away_m = middle_m_ ? glm::abs(tip_m - *middle_m_) : Vec3(kShown_m);
    if (std::max({away_m.x, away_m.y, away_m.z}) > kMaxBeside * kShown_m) middle_m_ = tip_m;
    const int each = std::max(kCoarse, (width - 2) / 3);
    for (int i = 0; i < 3; ++i) {
        const Way& way = kWays[std::size_t(i)];
        Cell& cell = cells_[std::size_t(i)];
        cell.rect = {i * (each + 1), 0, each, height};
        cell.m_per_pixel = kShown_m / std::max(kCoarse, std::min(each, height));
        const Vec3 normal = glm::cross(way.right, way.down);
        cell.plane = {way.title, *middle_m_ + normal * glm::dot(normal, tip_m - *middle_m_), way.right,
                      way.down, each * cell.m_per_pixel};
    }
}

void SliceView::drawTool(report::Canvas& canvas, const Cell& cell, const Pose& patient_from_tool,
                         double length_m) const {
    const report::Point tip = cell.pixelOf(patient_from_tool.position_m),
                        hub = cell.pixelOf(patient_from_tool * Vec3(0.0, 0.0, length_m));
    const Rect& r = cell.rect;
    const Colour thin = kCross.faded(0.35);
    canvas.line({double(r.x), tip.y}, {double(r.x + r.width), tip.y}, 1.0, thin);
    canvas.line({tip.x, double(r.y)}, {tip.x, double(r.y + r.height)}, 1.0, thin);
    canvas.line(hub, tip, 4.0, kDark.faded(0.6));
    canvas.line(hub, tip, 1.8, kTool);
    canvas.circle(tip, 4.5, 1.5, kTool);
}

void SliceView::draw(report::Canvas& canvas, int width, int height, const FrameState& seen) {
    canvas.rectangle(0, 0, width, height, kDark);
    Pose tool = activeToolPose(seen.tick);
    if (const auto tip_m = tipOnTrack_m(seen.tick, patient_->package().motion))
        tool = {seen.tick.patient_from_needle.rotation, *tip_m};
    const double length_m = haptics::isNeedleTool(seen.tick.tool) ? seen.needle.length_m : kHandle_m;
    place(width, height, tool.position_m);
    std::array<std::size_t, 256> labels{};
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        const Cell& cell = cells_[i];
        const Rect& r = cell.rect;
        const int across = std::max(1, r.width / kCoarse), down = std::max(1, r.height / kCoarse);
        canvas.clip(r.x, r.y, r.width, r.height);
        canvas.image(r.x, r.y, across, down,
                     report::samplePlane(*patient_, seen.tick.breath, cell.plane, across, down, labels),
                     double(r.width) / across);
        drawTool(canvas, cell, tool, length_m);
        const Way& way = kWays[i];
        const auto text = [&](double x, double y, const char* words, report::Align align, bool bold) {
            canvas.text({x, y}, words, {12, kWhite, align, bold, kDark.faded(0.7)});
        };
        text(r.x + 6, r.y + 15, way.title, report::Align::left, false);
        text(r.x + 6, r.y + 0.5 * r.height, way.left_letter, report::Align::left, true);
        text(r.x + r.width - 6, r.y + 0.5 * r.height, way.right_letter, report::Align::right, true);
        text(r.x + 0.5 * r.width + 8, r.y + 14, way.top_letter, report::Align::left, true);
        text(r.x + 0.5 * r.width + 8, r.y + r.height - 6, way.bottom_letter, report::Align::left, true);
        canvas.unclip();
    }
}

std::optional<SliceView::Spot> SliceView::at(double x, double y) const {
    for (const Cell& cell : cells_)
        if (cell.m_per_pixel > 0.0 && cell.rect.holds(x, y))
            return Spot{cell.plane.right, cell.plane.down, cell.m_per_pixel};
    return std::nullopt;
}

}  // namespace stylet::trainer
