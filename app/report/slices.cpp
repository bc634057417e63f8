#include "app/report/slices.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/report/canvas.h"
#include "app/report/sheet_colours.h"
#include "base/whole_file.h"

namespace stylet::report {

using patient::Label;
using patient::Patient;

namespace {

constexpr std::size_t kFewPixels = 300;  // labels with fewer pixels are left out of the legend
constexpr int kPanelPixels = 560, kSlicesMargin = 24, kSlicesHeader = 104, kSlicesFooter = 92;
constexpr int kSheetWidth = 4 * kSlicesMargin + 3 * kPanelPixels,
              kSheetHeight = kSlicesHeader + kPanelPixels + kSlicesFooter;
constexpr Colour kNeedle{0.35, 0.90, 1.0}, kCross{1.0, 0.85, 0.35};
constexpr Colour kTrail{1.0, 0.62, 0.15}, kReference{0.95, 0.95, 0.95};

// The unit vector perpendicular to `normal` that is nearest to `wanted`.
Vec3 perpendicularTo(const Vec3& wanted, const Vec3& normal) {
    const Vec3 flat = wanted - glm::dot(wanted, normal) * normal;
    const double length = glm::length(flat);
    if (length > 1e-6) return flat / length;
    return perpendicularTo(Vec3(wanted.y, wanted.z, wanted.x), normal);
}

double trilinear(const CtVolume& ct, const Vec3& p) {
    const Vec3 v = ct.grid.toVoxels(p);
    const Vec3 base = glm::floor(v), f = v - base;
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const Index3 step(corner & 1, (corner >> 1) & 1, corner >> 2);
        const Index3 i = Index3(base) + step;
        const double weight =
            (step.x ? f.x : 1.0 - f.x) * (step.y ? f.y : 1.0 - f.y) * (step.z ? f.z : 1.0 - f.z);
        sum += weight * (ct.grid.contains(i) ? double(ct[i]) : -1000.0);
    }
    return sum;
}

double labelTint(const Label& label) {
    if (label.role == patient::Role::target) return 0.50;
    if (label.tissue == patient::Tissue::vessel) return 0.34;
    if (label.tissue == patient::Tissue::liver) return 0.12;
    if (label.tissue == patient::Tissue::fascia) return 0.20;
    return 0.0;
}

// The letter of the patient's side that a picture direction points to.
std::string sideLetter(const Vec3& d) {
    const Vec3 size = glm::abs(d);
    if (size.x >= size.y && size.x >= size.z) return d.x > 0 ? "R" : "L";
    if (size.y >= size.z) return d.y > 0 ? "A" : "P";
    return d.z > 0 ? "H" : "F";
}

// Position of one panel on the sheet.
struct SlicePanel {
    const SlicePlane& plane;
    double x, y;
    Point at(const Vec3& p) const {
        const double scale = kPanelPixels / plane.width_m;
        const Vec3 d = p - plane.centre_m;
        return {x + 0.5 * kPanelPixels + scale * glm::dot(d, plane.right),
                y + 0.5 * kPanelPixels + scale * glm::dot(d, plane.down)};
    }
};

void drawNeedle(Canvas& canvas, const SlicePanel& panel, const NeedlePicture& needle) {
    const Point tip = panel.at(needle.tip_m), back = panel.at(needle.tip_m - needle.axis * 0.3);
    const double gap = 16.0, right = panel.x + kPanelPixels, bottom = panel.y + kPanelPixels;
    const Colour thin = kCross.faded(0.45);
    canvas.line({panel.x, tip.y}, {tip.x - gap, tip.y}, 1, thin);
    canvas.line({tip.x + gap, tip.y}, {right, tip.y}, 1, thin);
    canvas.line({tip.x, panel.y}, {tip.x, tip.y - gap}, 1, thin);
    canvas.line({tip.x, tip.y + gap}, {tip.x, bottom}, 1, thin);
    if (std::hypot(back.x - tip.x, back.y - tip.y) < 2.0) {
        canvas.circle(tip, 5.0, 3.5, kDark.faded(0.7));
        canvas.circle(tip, 5.0, 1.8, kNeedle);
        return;
    }
    canvas.dashed(tip, panel.at(needle.target_m), 1.5, kNeedle.faded(0.9));
    canvas.line(back, tip, 4.0, kDark.faded(0.6));
    canvas.line(back, tip, 1.8, kNeedle);
    canvas.circle(tip, 7.0, 1.5, kNeedle);
}

void drawTrail(Canvas& canvas, const SlicePanel& panel, const NeedlePicture& needle) {
    const auto polyline = [&](const std::vector<Vec3>& places_m, double width, Colour colour) {
        std::vector<Point> points;
        for (const Vec3& place_m : places_m)
            points.push_back(panel.at(place_m));
        if (points.size() > 1) canvas.polyline(points, width, colour);
    };
    if (needle.reference_m.size() == 2)
        canvas.dashed(panel.at(needle.reference_m[0]), panel.at(needle.reference_m[1]), 2.5, kReference);
    polyline(needle.trail_m, 3.5, kDark.faded(0.5));
    polyline(needle.trail_m, 1.6, kTrail);
}

// Legend of the lines, right of the labels' legend.
void drawLineLegend(Canvas& canvas, const NeedlePicture& needle, double right, double y) {
    const TextStyle style{14, kWhite, Align::right};
    const auto entry = [&](const std::string& text, Colour colour, bool dashed) {
        canvas.text({right, y}, text, style);
        const double end = right - canvas.textWidth(text, style) - 8.0;
        if (dashed)
            canvas.dashed({end - 34, y - 5}, {end, y - 5}, 2.5, colour);
        else
            canvas.line({end - 34, y - 5}, {end, y - 5}, 2.5, colour);
        right = end - 34 - 26;
    };
    if (!needle.reference_m.empty()) entry("reference path", kReference, true);
    if (!needle.trail_m.empty()) entry("way of the tip", kTrail, false);
    if (!needle.trail_m.empty() || !needle.reference_m.empty()) entry("needle", kNeedle, false);
}

void drawScale(Canvas& canvas, const SlicePanel& panel) {
    const double bar_m = panel.plane.width_m > 0.12 ? 0.05 : 0.01;
    const double width = bar_m / panel.plane.width_m * kPanelPixels;
    const double right = panel.x + kPanelPixels - 18, y = panel.y + kPanelPixels - 18;
    canvas.line({right - width, y}, {right, y}, 5.0, kDark.faded(0.6));
    canvas.line({right - width, y}, {right, y}, 2.5, kWhite);
    canvas.text({right - 0.5 * width, y - 8}, fmt::format("{:.0f} mm", bar_m * 1000.0),
                {13, kWhite, Align::centre, false, kDark.faded(0.7)});
}

void drawLetters(Canvas& canvas, const SlicePanel& panel) {
    const TextStyle style{15, kWhite, Align::centre, true, kDark.faded(0.7)};
    const double middle = 0.5 * kPanelPixels;
    canvas.text({panel.x + kPanelPixels - 14, panel.y + middle - 8}, sideLetter(panel.plane.right), style);
    canvas.text({panel.x + 14, panel.y + middle - 8}, sideLetter(-panel.plane.right), style);
    canvas.text({panel.x + middle + 12, panel.y + 20}, sideLetter(-panel.plane.down), style);
    canvas.text({panel.x + middle + 12, panel.y + kPanelPixels - 10}, sideLetter(panel.plane.down), style);
}

// Legend of the tinted labels found in any panel.
void drawLabelLegend(Canvas& canvas, const Patient& patient, const std::array<std::size_t, 256>& seen,
                     double y) {
    double x = kSlicesMargin;
    for (std::size_t id = 1; id < seen.size(); ++id) {
        const Label* label = patient.label(std::uint8_t(id));
        if (!label || seen[id] < kFewPixels || labelTint(*label) == 0.0) continue;
        const Colour colour{label->colour[0] / 255.0, label->colour[1] / 255.0, label->colour[2] / 255.0};
        x = drawSwatch(canvas, {x, y}, colour, label->name, label->role == patient::Role::target);
    }
}

}  // namespace

std::array<SlicePlane, 3> slicePlanes(const NeedlePicture& needle) {
    const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    // The panels along the needle show its path from the skin to slightly behind the tip.
    const Vec3 middle = needle.tip_m - 0.2 * needle.depth_m * needle.axis;
    const auto along = [&](const char* title, const Vec3& normal_wanted, const Vec3& down_wanted) {
        const Vec3 normal = perpendicularTo(normal_wanted, needle.axis);
        const Vec3 right = perpendicularTo(-x, normal);
        Vec3 down = glm::cross(normal, right);
        if (glm::dot(down, down_wanted) < 0.0) down = -down;
        return SlicePlane{title, middle, right, down, 0.21};
    };
    const Vec3 down = perpendicularTo(-z, needle.axis);
    return {
        along("Along the needle, near axial", z, -y), along("Along the needle, near coronal", y, -z),
        SlicePlane{"Across the needle at the tip", needle.tip_m, glm::cross(down, needle.axis), down, 0.07}};
}

std::vector<std::uint8_t> samplePlane(const Patient& patient, const patient::Surrogate& breath,
                                      const SlicePlane& plane, int width, int height,
                                      std::array<std::size_t, 256>& seen) {
    const patient::Package& package = patient.package();
    std::vector<std::uint8_t> rgb;
    rgb.reserve(std::size_t(width) * std::size_t(height) * 3);
    const double pitch_m = plane.width_m / width, half_x = 0.5 * (width - 1), half_y = 0.5 * (height - 1);
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
            const Vec3 deformed =
                plane.centre_m + pitch_m * ((i - half_x) * plane.right + (j - half_y) * plane.down);
            const Vec3 p = referenceFromDeformed(package.motion, breath, deformed);
            const double grey = std::clamp(
                (trilinear(package.ct, p) - kWindowLow_hu) / (kWindowHigh_hu - kWindowLow_hu), 0.0, 1.0);
            const std::uint8_t id = package.labels.nearestOr(p, 0);
            const Label* label = patient.label(id);
            ++seen[id];
            const double tint = label ? labelTint(*label) : 0.0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double colour = label ? label->colour[k] / 255.0 : 0.0;
                // Scaled by the underlying grey value, so that the CT shows through the tint.
                const double tinted = colour * (0.35 + 0.9 * grey);
                rgb.push_back(
                    std::uint8_t(std::lround(255.0 * std::min(1.0, grey + tint * (tinted - grey)))));
            }
        }
    return rgb;
}

SliceSheet sliceSheet(const Patient& patient, const NeedlePicture& needle) {
    Canvas canvas(kSheetWidth, kSheetHeight, kDark);
    const std::array<SlicePlane, 3> planes = slicePlanes(needle);
    canvas.text({kSlicesMargin, 44}, needle.title, {24, kWhite, Align::left, true});
    std::array<std::size_t, 256> seen{};
    double x = kSlicesMargin;
    for (const SlicePlane& plane : planes) {
        const SlicePanel panel{plane, x, kSlicesHeader};
        canvas.text({x, kSlicesHeader - 14}, plane.title, {16, kWhite});
        canvas.image(x, kSlicesHeader, kPanelPixels, kPanelPixels,
                     samplePlane(patient, needle.breath, plane, kPanelPixels, kPanelPixels, seen));
        canvas.clip(x, kSlicesHeader, kPanelPixels, kPanelPixels);
        drawTrail(canvas, panel, needle);
        drawNeedle(canvas, panel, needle);
        drawScale(canvas, panel);
        drawLetters(canvas, panel);
        canvas.unclip();
        x += kPanelPixels + kSlicesMargin;
    }
    drawLabelLegend(canvas, patient, seen, kSlicesHeader + kPanelPixels + 34);
    canvas.text({kSlicesMargin, kSlicesHeader + kPanelPixels + 68},
                fmt::format("{}   |   CT window {:.0f} HU around {:.0f} HU", needle.caption,
                            kWindowHigh_hu - kWindowLow_hu, 0.5 * (kWindowHigh_hu + kWindowLow_hu)),
                {14, kGrey});
    drawLineLegend(canvas, needle, kSheetWidth - kSlicesMargin, kSlicesHeader + kPanelPixels + 68);
    return {canvas.png(), kSheetWidth, kSheetHeight};
}

void drawSlices(const Patient& patient, const NeedlePicture& needle, const std::filesystem::path& png) {
    const SliceSheet sheet = sliceSheet(patient, needle);
    writeWholeFile(png, {reinterpret_cast<const char*>(sheet.png.data()), sheet.png.size()});
}

}  // namespace stylet::report
