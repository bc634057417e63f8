#include "haptics/tools/tube.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/tools/instrument.h"

namespace stylet::haptics {

using patient::Patient;
using patient::Tissue;
using patient::TissueRow;

namespace {

constexpr int kTaperSamples = 4;
constexpr double kMaxSlide_m = 0.001;  // per tick; a faster hand stretches the spring
constexpr double kMaxTube_n = 22.0;    // as against bone

// Past the skin and the fascia, so that unlabelled voxels inside the body are soft tissue.
const TissueRow* rowAt(const Patient& patient, const TubePath& path, double depth_m) noexcept {
    const Tissue tissue = patient.at(pointAt(path, depth_m), {true, true}).tissue;
    return depth_m <= 0.0 || tissue == Tissue::air ? nullptr : &patient.row(tissue);
}

}  // namespace

double pathLength_m(std::span<const Vec3> points_m) noexcept {
    double sum_m = 0.0;
    for (std::size_t i = 1; i < points_m.size(); ++i)
        sum_m += glm::length(points_m[i] - points_m[i - 1]);
    return sum_m;
}

Vec3 pointAt(const TubePath& path, double depth_m) noexcept {
    const std::span<const Vec3> p = path.points_m;
    double left_m = depth_m;
    for (std::size_t i = 1;; ++i) {
        const Vec3 step = p[i] - p[i - 1];
        const double l = glm::length(step);
        if (left_m <= l || i + 1 == p.size()) return p[i - 1] + (l > 0.0 ? left_m / l : 0.0) * step;
        left_m -= l;
    }
}

TubeResistance tubeResistance(const TubeSettings& settings, const TubePath& path, const Opening& opening,
                              const Patient& patient, double depth_m) noexcept {
    TubeResistance sum;
    const double scale = settings.outer_m / kPaperNeedle_m;
    if (const TissueRow* row = rowAt(patient, path, depth_m)) sum.friction_n = scale * row->friction_n;
    for (int i = 0; i < kTaperSamples; ++i) {
        // Where the taper has this diameter, the tissue is widened to it from the opening.
        const double share = (i + 0.5) / kTaperSamples;
        const double at_m = depth_m - share * settings.taper_m;
        const double widened_m = settings.outer_m - std::max(opening.at(at_m), 0.0);
        const TissueRow* row = rowAt(patient, path, at_m);
        if (!row || widened_m <= 0.0) continue;
        const double cut_n = std::min(row->cut_force_n, kMaxTube_n);  // bone is never cut
        sum.widening_n += cut_n * scale * (widened_m / settings.outer_m) / kTaperSamples;
    }
    return sum;
}

double stepTube(TubeState& s, const TubeSettings& settings, const TubePath& path, const Opening& opening,
                const Patient& patient, double moved_m) noexcept {
    const double k = settings.stiffness_n_per_m;
    if (!std::isfinite(moved_m)) moved_m = 0.0;
    s.extension_m += moved_m;
    const TubeResistance r = tubeResistance(settings, path, opening, patient, s.depth_m);
    const double in_n = r.friction_n + r.widening_n;
    if (k * s.extension_m > in_n) {
        const double wanted_m = std::min(s.extension_m - in_n / k, kMaxSlide_m);
        const double room_m = std::max(0.0, path.length_m - s.depth_m);
        const double travel_m = std::min(wanted_m, room_m);
        s.depth_m += travel_m;
        s.extension_m -= travel_m;
        s.stopped = travel_m < wanted_m;
        const double most_n = s.stopped ? in_n + settings.blunt_n : in_n + k * kMaxSlide_m;
        s.extension_m = std::min(s.extension_m, std::min(most_n, kMaxTube_n) / k);
    } else if (k * s.extension_m < -r.friction_n) {
        const double travel_m = std::max(s.extension_m + r.friction_n / k, -kMaxSlide_m);
        s.depth_m += travel_m;
        s.extension_m = std::max(s.extension_m - travel_m, -r.friction_n / k - kMaxSlide_m);
        s.stopped = false;
    }
    s.tissue = s.depth_m > 0.0 ? patient.at(pointAt(path, s.depth_m), {true, true}).tissue : Tissue::air;
    return k * s.extension_m;
}

double tubeEnergy_j(const TubeState& s, const TubeSettings& settings) noexcept {
    return 0.5 * settings.stiffness_n_per_m * s.extension_m * s.extension_m;
}

void hashTube(StateHash& hash, const TubeState& s) noexcept {
    hash.add(s.depth_m, s.extension_m, std::uint64_t(s.tissue) | std::uint64_t(s.stopped) << 8);
}

}  // namespace stylet::haptics
