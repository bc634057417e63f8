#include "app/report/classes.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "app/report/canvas.h"
#include "app/report/sheet_colours.h"

namespace stylet::report {

using patient::Patient;
using patient::Tissue;

namespace {

constexpr int kSlicePixels = 470, kClassesMargin = 24, kClassesHeader = 96, kClassesFooter = 70;
// The paper's colours.
constexpr Colour kAir{0.45, 0.47, 0.50}, kSkin{0.95, 0.56, 0.16}, kSoft{0.96, 0.86, 0.25},
    kBone{0.58, 0.30, 0.80}, kFascia{0.95, 0.10, 0.75}, kDuct{0.20, 0.75, 0.25}, kVessel{0.86, 0.12, 0.12};
constexpr double kShownLow_hu = -1050.0, kShownHigh_hu = 1000.0, kBin_hu = 10.0;

Colour classColour(double hu, const patient::Thresholds& t, bool past_fascia) {
    if (hu < t.t0_hu) return kAir;
    if (hu < t.t1_hu) return kSkin;
    return hu < (past_fascia ? t.t2_specific_hu : t.t2_sensitive_hu) ? kSoft : kBone;
}

enum class ClassView { before_fascia, past_fascia, with_structures };

Colour colourAt(const Patient& patient, const Index3& at, ClassView shown) {
    const patient::Package& package = patient.package();
    const patient::Label* label = patient.label(package.labels[at]);
    if (label && shown != ClassView::before_fascia && label->tissue == Tissue::fascia) return kFascia;
    if (label && shown == ClassView::with_structures) {
        if (label->tissue == Tissue::duct) return kDuct;
        if (label->tissue == Tissue::vessel) return kVessel;
    }
    return classColour(package.ct[at], package.thresholds, shown != ClassView::before_fascia);
}

// An axial slice in radiological orientation: seen from the feet, front up. Class colours over the CT's
// greys.
std::vector<std::uint8_t> slice(const Patient& patient, int z, ClassView shown) {
    const Grid& grid = patient.grid();
    const Vec3 size_m = grid.spacing_m * Vec3(grid.dims);
    const double pixel_m = std::max(size_m.x, size_m.y) / kSlicePixels;
    const Vec3 middle = grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
    std::vector<std::uint8_t> rgb;
    rgb.reserve(std::size_t(kSlicePixels) * kSlicePixels * 3);
    for (int v = 0; v < kSlicePixels; ++v)
        for (int u = 0; u < kSlicePixels; ++u) {
            const double x = middle.x - (u + 0.5 - 0.5 * kSlicePixels) * pixel_m;
            const double y = middle.y - (v + 0.5 - 0.5 * kSlicePixels) * pixel_m;
            const Index3 at = grid.nearest({x, y, grid.centre({0, 0, z}).z});
            Colour c = kDark;
            if (grid.contains(at)) {
                const double grey = std::clamp((double(patient.package().ct[at]) + 250.0) / 600.0, 0.0, 1.0);
                const Colour over = colourAt(patient, at, shown);
                const double shade = 0.55 + 0.45 * grey;
                c = {over.r * shade, over.g * shade, over.b * shade};
            }
            for (const double channel : {c.r, c.g, c.b})
                rgb.push_back(std::uint8_t(std::lround(255.0 * channel)));
        }
    return rgb;
}

std::vector<double> computeHistogram(const CtVolume& ct) {
    std::vector<double> counts(std::size_t((kShownHigh_hu - kShownLow_hu) / kBin_hu), 0.0);
    for (const std::int16_t hu : ct.voxels) {
        const double bin = (double(hu) - kShownLow_hu) / kBin_hu;
        if (bin >= 0.0 && bin < double(counts.size())) ++counts[std::size_t(bin)];
    }
    return counts;
}

// Counts on a logarithmic scale, because air would hide everything else. The upper part of each bar shows
// the class before the fascia, the foot the class past it.
void drawHistogram(Canvas& canvas, double x, double y, const Patient& patient) {
    const std::vector<double> counts = computeHistogram(patient.package().ct);
    const patient::Thresholds& t = patient.package().thresholds;
    const double most = std::log1p(*std::max_element(counts.begin(), counts.end()));
    const double width = double(kSlicePixels) / double(counts.size()), foot = 18.0;
    const auto at = [&](double hu) {
        return x + kSlicePixels * (hu - kShownLow_hu) / (kShownHigh_hu - kShownLow_hu);
    };
    for (std::size_t i = 0; i < counts.size(); ++i) {
        const double hu = kShownLow_hu + (double(i) + 0.5) * kBin_hu;
        const double height = most > 0.0 ? (kSlicePixels - 90) * std::log1p(counts[i]) / most : 0.0;
        const double left = x + double(i) * width, base = y + kSlicePixels - 50;
        canvas.rectangle(left, base - height, width + 0.5, height, classColour(hu, t, false));
        canvas.rectangle(left, base + 4, width + 0.5, foot, classColour(hu, t, true));
    }
    const std::array<std::pair<const char*, double>, 4> marks{
        {{"t0", t.t0_hu}, {"t1", t.t1_hu}, {"t2-", t.t2_sensitive_hu}, {"t2+", t.t2_specific_hu}}};
    for (std::size_t i = 0; i < marks.size(); ++i) {
        const double line = at(marks[i].second), top = y + 14 + 17.0 * double(i);
        canvas.line({line, top + 4}, {line, y + kSlicePixels - 28}, 1.0, kWhite.faded(0.6));
        const bool right = line < x + 0.6 * kSlicePixels;
        canvas.text({line + (right ? 5.0 : -5.0), top + 6},
                    fmt::format("{} = {:.0f} HU", marks[i].first, marks[i].second),
                    {13, kWhite, right ? Align::left : Align::right, false, kDark.faded(0.7)});
    }
    for (int hu = -1000; hu <= 1000; hu += 500)
        canvas.text({at(hu), y + kSlicePixels - 8}, std::to_string(hu), {12, kGrey, Align::centre});
}

void drawClassLegend(Canvas& canvas, double y) {
    double x = kClassesMargin;
    const std::array<std::pair<const char*, Colour>, 7> entries{{{"air", kAir},
                                                                 {"skin", kSkin},
                                                                 {"soft tissue", kSoft},
                                                                 {"bone", kBone},
                                                                 {"fascia", kFascia},
                                                                 {"bile duct", kDuct},
                                                                 {"vessel", kVessel}}};
    for (const auto& [name, colour] : entries)
        x = drawSwatch(canvas, {x, y}, colour, name);
}

}  // namespace

void drawClasses(const Patient& patient, const Vec3& at_reference_m, const std::string& title,
                 const std::filesystem::path& png) {
    const Grid& grid = patient.grid();
    const int z = std::clamp(grid.nearest(at_reference_m).z, 0, grid.dims.z - 1);
    Canvas canvas(5 * kClassesMargin + 4 * kSlicePixels, kClassesHeader + kSlicePixels + kClassesFooter,
                  kDark);
    canvas.text({kClassesMargin, 42}, title, {22, kWhite, Align::left, true});
    double x = kClassesMargin;
    const auto panel = [&](const char* caption) {
        canvas.text({x, kClassesHeader - 14}, caption, {15, kWhite});
        return std::exchange(x, x + kSlicePixels + kClassesMargin);
    };
    drawHistogram(canvas, panel("CT values; foot: as past the fascia"), kClassesHeader, patient);
    const auto show = [&](const char* caption, ClassView shown) {
        const double left = panel(caption);
        canvas.image(left, kClassesHeader, kSlicePixels, kSlicePixels, slice(patient, z, shown));
    };
    show("before the fascia", ClassView::before_fascia);
    show("past the fascia", ClassView::past_fascia);
    show("with segmented ducts and vessels", ClassView::with_structures);
    drawClassLegend(canvas, kClassesHeader + kSlicePixels + 36);
    canvas.savePng(png);
}

}  // namespace stylet::report
