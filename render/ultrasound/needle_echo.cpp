#include "render/ultrasound/needle_echo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace stylet::render {
namespace {

constexpr double kTipReach_m = 0.0015;  // distance from the tip at which the echo of its edge fades
// A needle of kShadowing_m halfway to the focus lets three quarters of a beam of 6 mm pass, in each
// direction. A thinner one shadows in proportion to its width.
constexpr double kMaxShadow = 0.47, kShadowing_m = 0.0015;
constexpr std::size_t kMaxNeedleLines = 1024;
constexpr double kFaintest = 0.02;  // weight below which the needle is not seen

struct Meeting {
    double along_line_m = 0.0, along_needle_m = 0.0, cost = 0.0;
};

// Finds where line and shaft come nearest to each other. Distances perpendicular to the picture's plane are
// in units of `sigma`, distances in the plane in units of `width`.
Meeting nearest(const ScanLine& line, const Vec3& tip, const Vec3& axis, double length, double width,
                double sigma) {
    const Vec3 scale(1.0 / width, 1.0 / sigma, 1.0 / width);
    const Vec3 d = scale * line.direction, a = scale * axis, from = scale * (line.origin_m - tip);
    const double dd = glm::dot(d, d), aa = glm::dot(a, a), da = glm::dot(d, a);
    const double determinant = dd * aa - da * da;
    Meeting m;
    if (determinant > 1e-9 * dd * aa)
        m.along_needle_m = (dd * glm::dot(a, from) - da * glm::dot(d, from)) / determinant;
    m.along_needle_m = std::clamp(m.along_needle_m, 0.0, length);
    m.along_line_m = (da * m.along_needle_m - glm::dot(d, from)) / dd;
    const Vec3 apart = from + d * m.along_line_m - a * m.along_needle_m;
    m.cost = glm::dot(apart, apart);
    return m;
}

}  // namespace

NeedleEcho needleEcho(const Transducer& probe, const ScanLine& line, double pitch_m,
                      const Pose& probe_from_needle, const NeedleShape& needle, double reflectivity) {
    const Vec3 tip = probe_from_needle.position_m, axis = probe_from_needle.direction({0, 0, 1});
    const double width = needle.radius_m() + 0.5 * pitch_m;
    Meeting m;
    m.along_line_m = std::max(tip.z, 0.0);
    for (int i = 0; i < 3; ++i) {  // iterate, because the beam's thickness depends on the depth
        const double sigma = beamThickness_m(probe, std::max(m.along_line_m, 0.0)) / kWidthsPerSigma;
        m = nearest(line, tip, axis, needle.length_m, width, sigma);
    }
    const double weight = std::exp(-0.5 * m.cost);
    if (!(weight > kFaintest) || m.along_line_m <= 0.0) return {};
    const double off = std::asin(std::min(std::fabs(glm::dot(line.direction, axis)), 1.0));
    const double half_widths = off / (0.5 * kNeedleLobe_rad);
    const double glint = std::exp2(-half_widths * half_widths);
    const double tip_glow = needle.tip_echo * std::exp(-m.along_needle_m / kTipReach_m);
    return {m.along_line_m, reflectivity * weight * std::min(glint + needle.shaft_echo + tip_glow, 1.0),
            kMaxShadow * std::min(1.0, needle.outer_m / kShadowing_m) * weight};
}

void spreadShadows(const Transducer& probe, std::span<NeedleEcho> lines) {
    std::array<double, kMaxNeedleLines> cast{};
    const std::size_t count = std::min(lines.size(), cast.size());
    std::size_t nearest = count;  // index of the nearest line with an echo
    for (std::size_t i = 0; i < count; ++i) {
        cast[i] = lines[i].shadow;
        if (nearest == count && lines[i].depth_m > 0.0) nearest = i;
    }
    if (nearest == count) return;
    for (std::size_t i = 0; i < count; ++i) {
        if (lines[i].depth_m > 0.0) nearest = i;
        const double depth_m = lines[nearest].depth_m;
        // A beam focused at twice the needle's depth is half as wide as the aperture where it passes the
        // needle.
        const double reach_m = 0.25 * probe.aperture_m;
        const auto reach = std::size_t(reach_m / linePitch_m(probe, int(count), depth_m));
        const std::size_t from = i - std::min(i, reach), to = std::min(count, i + reach + 1);
        lines[i].shadow = std::accumulate(cast.begin() + from, cast.begin() + to, 0.0) / double(to - from);
        if (lines[i].depth_m == 0.0 && lines[i].shadow > 0.0) lines[i].depth_m = depth_m;
    }
}

}  // namespace stylet::render
