#include "app/training/surroundings.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "base/distance.h"
#include "base/geodesic.h"

namespace stylet::training {

using patient::Label;
using patient::Patient;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kThreads = 2;
constexpr double kOuterAirSearch_m = 0.040;  // outer air is found within this distance in front of the entry
constexpr double kDuctPiece_m = 0.008;       // radius around the target in which the duct counts as straight
constexpr double kMinElongation = 3.0;       // least ratio of variances; below it there is no direction

// The part of the patient's grid around the path.
Grid gridAround(const Grid& whole, const patient::PlannedPath& path) {
    const Vec3 low_m = glm::min(path.entry_reference_m, path.target_reference_m) - kSurroundingsMargin_m;
    const Vec3 high_m = glm::max(path.entry_reference_m, path.target_reference_m) + kSurroundingsMargin_m;
    const Index3 last = whole.dims - 1;
    const Index3 low = glm::clamp(whole.nearest(low_m), Index3(0), last);
    const Index3 high = glm::clamp(whole.nearest(high_m), Index3(0), last);
    return {high - low + 1, whole.spacing_m, whole.centre(low)};
}

enum Mark : std::uint8_t { kAir = 1, kOuterAir = 2, kRisk = 4, kDuct = 8 };

// Classifies a voxel like the planner. Unlabelled voxels above the sensitive bone threshold are risks: past
// the fascia they are bone or a vessel with contrast medium.
std::uint8_t classifyVoxel(const Patient& patient, const Index3& i) {
    const patient::Package& p = patient.package();
    if (const Label* label = patient.label(p.labels[i])) {
        if (label->role == patient::Role::risk) return kRisk;
        return label->role == patient::Role::target ? kDuct : 0;
    }
    const double ct_hu = p.ct[i];
    if (ct_hu < p.thresholds.t0_hu) return kAir;
    return ct_hu < p.thresholds.t2_sensitive_hu ? 0 : kRisk;
}

// Marks the air connected to the air in front of the entry as outside. Other air is gas.
void findOuterAir(Volume<std::uint8_t>& marks, const patient::PlannedPath& path) {
    const Vec3 inward_m = path.target_reference_m - path.entry_reference_m;
    const double length_m = glm::length(inward_m);
    if (!(length_m > 0.0)) return;
    const Vec3 outward = -inward_m / length_m;
    std::vector<Index3> open;
    for (double at_m = 0.0; at_m < kOuterAirSearch_m && open.empty(); at_m += marks.grid.spacing_m.x) {
        const Index3 i = marks.grid.nearest(path.entry_reference_m + outward * at_m);
        if (marks.grid.contains(i) && marks[i] == kAir) open.push_back(i);
    }
    for (const Index3& i : open)
        marks[i] = kOuterAir;
    floodFaces(marks.grid, std::move(open), [&](const Index3& i) {
        if (marks[i] != kAir) return false;
        marks[i] = kOuterAir;
        return true;
    });
}

Volume<float> distanceToMarked(const Volume<std::uint8_t>& marks, std::uint8_t wanted) {
    Volume<std::uint8_t> mask(marks.grid);
    std::transform(marks.voxels.begin(), marks.voxels.end(), mask.voxels.begin(),
                   [&](std::uint8_t m) { return std::uint8_t((m & wanted) != 0); });
    return distanceTo(mask, Sites::all, kThreads);
}

// Longest axis of the piece of duct at the target, by power iteration on its second moments.
std::optional<Vec3> ductDirection(const Volume<std::uint8_t>& marks, const Vec3& target_m) {
    std::vector<Vec3> piece;
    Vec3 middle(0.0);
    const Index3 centre = marks.grid.nearest(target_m);
    const Index3 reach = Index3(glm::ceil(Vec3(kDuctPiece_m) / marks.grid.spacing_m));
    forEachVoxel(Grid{2 * reach + 1}, [&](const Index3& step) {
        const Index3 i = centre - reach + step;
        if (!marks.grid.contains(i) || marks[i] != kDuct) return;
        const Vec3 p = marks.grid.centre(i);
        if (glm::length(p - target_m) > kDuctPiece_m) return;
        piece.push_back(p);
        middle += p;
    });
    if (piece.size() < 3) return std::nullopt;
    middle /= double(piece.size());
    patient::Mat3 moments(0.0);
    for (const Vec3& p : piece)
        moments += glm::outerProduct(p - middle, p - middle);
    Vec3 along(0.57, 0.58, 0.59);
    constexpr int kIterations = 60;
    for (int n = 0; n < kIterations; ++n) {
        const Vec3 next = moments * along;
        const double length = glm::length(next);
        if (!(length > 0.0)) return std::nullopt;
        along = next / length;
    }
    const double longest = glm::dot(along, moments * along);
    const double others = 0.5 * (moments[0][0] + moments[1][1] + moments[2][2] - longest);
    if (!(longest > kMinElongation * others)) return std::nullopt;
    return along;
}

}  // namespace

Surroundings::Surroundings(const Patient& patient, const patient::PlannedPath& path) {
    Volume<std::uint8_t> marks(gridAround(patient.grid(), path));
    const Index3 corner = patient.grid().nearest(marks.grid.origin_m);
    forEachVoxel(marks.grid, [&](const Index3& i) { marks[i] = classifyVoxel(patient, i + corner); });
    findOuterAir(marks, path);
    const Vec3 s = marks.grid.spacing_m;
    half_voxel_m_ = 0.5 * std::max({s.x, s.y, s.z});
    risk_m_ = distanceToMarked(marks, kRisk | kAir);
    duct_m_ = distanceToMarked(marks, kDuct);
    duct_axis_ = ductDirection(marks, path.target_reference_m);
}

double Surroundings::toBorder(const Volume<float>& distance_m, const Vec3& reference_m) const noexcept {
    if (!distance_m.grid.contains(distance_m.grid.nearest(reference_m))) return kInfinity;
    return std::max(0.0, sampleTrilinear(distance_m, reference_m) - half_voxel_m_);
}

}  // namespace stylet::training
