#include "app/study/paths_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/report/canvas.h"
#include "base/parallel.h"

namespace stylet::study {

using patient::PlannedPath;
using patient::Tissue;
using patient::TissueMap;
using report::Canvas;
using report::Colour;
using report::Point;

namespace {

constexpr int kPixels = 270;  // side of a view before it is drawn at kZoom
constexpr double kZoom = 2.0, kPixel_m = 0.0011;
constexpr double kRayLength_m = 0.45;  // length of the rays; their midpoint is at the middle of the paths
constexpr double kTop = 76.0, kLeft = 10.0, kViewGap = 10.0;
constexpr std::size_t kMostDrawnPaths = 500;
constexpr double kMinQuality = 0.4;  // the planner keeps no paths below this quality
constexpr Colour kDark{0.07, 0.08, 0.09}, kLight{0.93, 0.94, 0.95}, kGrey{0.66, 0.69, 0.72};

// Surface appearance: its colour and the share of the remaining light that it absorbs.
struct Look {
    Vec3 colour{0.0};
    double opacity = 0.0;
};
// In the order of Tissue.
const std::array<Look, patient::kTissueCount> kLooks{{{},                            // air
                                                      {{0.85, 0.70, 0.60}, 0.10},    // skin
                                                      {},                            // soft
                                                      {{0.93, 0.90, 0.82}, 0.80},    // bone
                                                      {},                            // fascia
                                                      {{0.66, 0.34, 0.29}, 0.38},    // liver
                                                      {{0.35, 0.55, 0.85}, 0.45},    // vessel
                                                      {{0.35, 0.85, 0.50}, 0.85},    // duct
                                                      {{0.78, 0.86, 0.86}, 0.50}}};  // cartilage

struct View {
    std::string name;
    Vec3 centre_m, into, right, down;  // unit vectors: into the picture, to the right and down

    Point at(const Vec3& p_m) const {
        const Vec3 d = (p_m - centre_m) / kPixel_m;
        return {kZoom * (glm::dot(d, right) + 0.5 * kPixels), kZoom * (glm::dot(d, down) + 0.5 * kPixels)};
    }
};

View viewFrom(const std::string& name, const Vec3& centre_m, const Vec3& towards) {
    const Vec3 into = glm::normalize(towards), head(0.0, 0.0, 1.0);
    return {name, centre_m, into, glm::cross(into, head), -head};
}

class Renderer {
  public:
    explicit Renderer(const TissueMap& map) : map_(map) {
        const Vec3 s = map.grid().spacing_m;
        step_m_ = 0.7 * std::min({s.x, s.y, s.z});
    }

    std::vector<std::uint8_t> render(const View& view, int threads) const {
        std::vector<std::uint8_t> rgb(std::size_t(kPixels) * kPixels * 3);
        parallelFor(threads, std::size_t(kPixels), [&](std::size_t row) {
            for (int i = 0; i < kPixels; ++i) {
                const Vec3 light = ray(view, i, int(row));
                for (int c = 0; c < 3; ++c)
                    rgb[3 * (row * kPixels + std::size_t(i)) + std::size_t(c)] =
                        std::uint8_t(std::lround(255.0 * std::clamp(light[c], 0.0, 1.0)));
            }
        });
        return rgb;
    }

  private:
    Tissue tissueAt(const Index3& i) const { return map_.sample(map_.code(i), {true, true}).tissue; }

    // Outward surface normal, estimated from the positions of the tissue's voxels around this voxel.
    Vec3 outward(const Index3& i, Tissue t) const {
        Vec3 sum(0.0);
        for (int z = -2; z <= 2; ++z)
            for (int y = -2; y <= 2; ++y)
                for (int x = -2; x <= 2; ++x)
                    if (tissueAt(i + Index3(x, y, z)) == t) sum -= Vec3(x, y, z) * map_.grid().spacing_m;
        const double length = glm::length(sum);
        return length > 0.0 ? sum / length : Vec3(0.0);
    }

    Vec3 ray(const View& view, int column, int row) const {
        const Vec3 begin_m = view.centre_m +
                             kPixel_m * ((column + 0.5 - 0.5 * kPixels) * view.right +
                                         (row + 0.5 - 0.5 * kPixels) * view.down) -
                             0.5 * kRayLength_m * view.into;
        Vec3 light(0.0);
        double left = 1.0;
        Tissue before = Tissue::air;
        for (double x = 0.0; x < kRayLength_m && left > 0.03; x += step_m_) {
            const Index3 i = map_.grid().nearest(begin_m + x * view.into);
            const Tissue t = tissueAt(i);
            if (t == before) continue;
            before = t;
            const Look& look = kLooks[std::size_t(t)];
            if (look.opacity == 0.0) continue;
            const double facing = std::fabs(glm::dot(outward(i, t), view.into));
            light += left * look.opacity * (0.25 + 0.75 * facing) * look.colour;
            left *= 1.0 - look.opacity;
        }
        return light + left * Vec3(kDark.r, kDark.g, kDark.b);
    }

    const TissueMap& map_;
    double step_m_ = 0.001;
};

// Green for the best, as in the paper. The colours also differ in lightness.
Colour qualityColour(double quality) {
    constexpr std::array<Colour, 3> kStops{{{0.75, 0.16, 0.12}, {0.98, 0.78, 0.20}, {0.25, 0.95, 0.45}}};
    return report::interpolate(kStops, (quality - kMinQuality) / (1.0 - kMinQuality)).faded(0.75);
}

// Picks at most kMostDrawnPaths paths, evenly spaced. The planner sorts the best first. The result has the
// best last, so that they are drawn on top.
std::vector<const PlannedPath*> selectPaths(std::span<const PlannedPath> paths) {
    const std::size_t count = std::min(paths.size(), kMostDrawnPaths);
    std::vector<const PlannedPath*> some;
    for (std::size_t i = count; i-- > 0;)
        some.push_back(&paths[i * paths.size() / count]);
    return some;
}

Vec3 boundingBoxCentre(std::span<const PlannedPath> paths) {
    Vec3 low = paths[0].entry_reference_m, high = low;
    for (const PlannedPath& p : paths)
        for (const Vec3& end : {p.entry_reference_m, p.target_reference_m})
            low = glm::min(low, end), high = glm::max(high, end);
    return 0.5 * (low + high);
}

void drawPaths(Canvas& canvas, const View& view, Point corner, const std::vector<const PlannedPath*>& paths) {
    const double side = kZoom * kPixels;
    canvas.clip(corner.x, corner.y, side, side);
    for (const PlannedPath* p : paths) {
        const Point a = view.at(p->entry_reference_m), b = view.at(p->target_reference_m);
        const Point from{corner.x + a.x, corner.y + a.y}, to{corner.x + b.x, corner.y + b.y};
        canvas.line(from, to, 1.2, qualityColour(p->quality));
        canvas.disc(from, 2.0, qualityColour(p->quality));
    }
    canvas.unclip();
    canvas.text({corner.x + 10.0, corner.y + 22.0}, view.name,
                {15.0, kLight, report::Align::left, true, kDark});
}

void drawScale(Canvas& canvas) {
    constexpr double kWide = 220.0, kRight = kPathsPictureWidth - 12.0, kY = 22.0;
    for (int i = 0; i < int(kWide); ++i)
        canvas.rectangle(kRight - kWide + i, kY, 1.5, 16.0,
                         qualityColour(kMinQuality + (1.0 - kMinQuality) * i / kWide).faded(1.0));
    const auto label = [&](double q, report::Align align) {
        canvas.text({kRight - kWide * (1.0 - q) / (1.0 - kMinQuality), kY + 34.0}, fmt::format("{:.1f}", q),
                    {14.0, kGrey, align});
    };
    label(kMinQuality, report::Align::left);
    label(0.5 * (1.0 + kMinQuality), report::Align::centre);
    label(1.0, report::Align::right);
    canvas.text({kRight - kWide - 10.0, kY + 14.0}, "quality Q", {15.0, kLight, report::Align::right});
}

}  // namespace

std::vector<std::uint8_t> pathsPicture(const TissueMap& map, std::span<const PlannedPath> paths,
                                       const std::string& title, int threads) {
    if (paths.empty()) return {};
    Canvas canvas(kPathsPictureWidth, kPathsPictureHeight, kDark);
    const std::vector<const PlannedPath*> some = selectPaths(paths);
    canvas.text({kLeft + 4.0, 32.0}, title, {20.0, kLight, report::Align::left, true});
    canvas.text({kLeft + 4.0, 56.0}, fmt::format("{} paths, {} drawn", paths.size(), some.size()),
                {15.0, kGrey});
    drawScale(canvas);
    const Renderer renderer(map);
    const Vec3 centre_m = boundingBoxCentre(paths);
    double left = kLeft;
    for (const View& view : {viewFrom("from the right", centre_m, {-1.0, -0.3, 0.0}),
                             viewFrom("from the front", centre_m, {0.0, -1.0, 0.0})}) {
        canvas.image(left, kTop, kPixels, kPixels, renderer.render(view, threads), kZoom);
        drawPaths(canvas, view, {left, kTop}, some);
        left += kZoom * kPixels + kViewGap;
    }
    return canvas.png();
}

}  // namespace stylet::study
