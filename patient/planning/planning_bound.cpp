#include "patient/planning/planning_bound.h"

namespace stylet::patient {
namespace {

// Bound of a path that meets a risk structure. It is below every quality.
constexpr double kRejectedPath = -1.0;

struct PointSample {
    Index3 voxel{0};
    bool sure = false;  // the point is in `voxel` and not close to its faces
};

}  // namespace

struct QualityBound::Line {
    Vec3 start, step;  // in voxels, cell borders at integers
    // Index3() truncates toward zero, which is not floor() for negative coordinates. Their `share` is
    // negative, so such a point is not `sure`.
    PointSample samplePoint(double at_m) const {
        constexpr double kNear = 1e-4, kFar = 1.0 - kNear;
        const Vec3 at = start + step * at_m;
        const Index3 voxel(at);
        const Vec3 share = at - Vec3(voxel);
        return {voxel, share.x > kNear && share.y > kNear && share.z > kNear && share.x < kFar &&
                           share.y < kFar && share.z < kFar};
    }
};

QualityBound::QualityBound(const Plan& plan)
    : plan_(plan), grid_(plan.patient.grid()), corner_(grid_.nearest(plan.region.clearance_m.grid.origin_m)) {
    const Vec3 s = grid_.spacing_m;
    half_voxel_m_ = 0.5 * std::min({s.x, s.y, s.z});
}

double QualityBound::bound(const PlannedPath& path, double needed) const {
    const double length_m = glm::length(path.target_m - path.entry_m);
    const Line line{grid_.toVoxels(path.entry_m) + 0.5,
                    (path.target_m - path.entry_m) / (grid_.spacing_m * length_m)};
    const double wall_m = outsideDuct(line, length_m, 0.0, -half_voxel_m_);
    const double far_m = outsideDuct(line, length_m, length_m + kBeyondTarget_m, half_voxel_m_);
    const double target_score = toScore(far_m - wall_m + kCorner_m, kFullChord_m);
    const double needed_m = (2.0 * needed - target_score) * kFullClearance_m;
    double clearance_m = kFullClearance_m;
    if (needed_m > clearance_m) return pathQuality(1.0, target_score);
    const double counts_to_m = wall_m - plan_.settings.near_target_m - kCorner_m;
    for (double at_m = 0.0; at_m < counts_to_m;) {
        const PointSample point = line.samplePoint(at_m);
        const double here_m = clearance(point.voxel);
        if (point.sure) {
            clearance_m = std::min(clearance_m, here_m);
            if (here_m < 0.0 && blocks(point.voxel)) return kRejectedPath;
            if (here_m < needed_m) {
                const double bound = pathQuality(toScore(clearance_m, kFullClearance_m), target_score);
                if (bound < needed) return bound;
            }
        }
        // Clearance decreases by at most the distance travelled.
        at_m += std::max(here_m - std::max(0.0, needed_m), half_voxel_m_);
    }
    return pathQuality(toScore(clearance_m, kFullClearance_m), target_score);
}

double QualityBound::clearance(const Index3& voxel) const {
    const Volume<float>& clearance_m = plan_.region.clearance_m;
    const Index3 i = voxel - corner_;
    return clearance_m.grid.contains(i) ? double(clearance_m[i]) : kFullClearance_m;
}

// True if the voxel is a risk whatever the needle has passed before.
bool QualityBound::blocks(const Index3& voxel) const {
    const TissueMap::Code code = plan_.map.code(voxel);
    return std::all_of(kAllTrackFlags.begin(), kAllTrackFlags.end(),
                       [&](TrackFlags flags) { return plan_.map.sample(code, flags).role == Role::risk; });
}

bool QualityBound::isDuct(const Index3& voxel) const {
    return plan_.map.sample(plan_.map.code(voxel), {}).tissue == Tissue::duct;
}

// First depth that is certainly outside the duct, searching from `from_m` in steps of `step_m`; `last_m`
// if there is none.
double QualityBound::outsideDuct(const Line& line, double from_m, double last_m, double step_m) const {
    const int steps = int((last_m - from_m) / step_m);
    for (int i = 1; i <= steps; ++i) {
        const PointSample point = line.samplePoint(from_m + i * step_m);
        if (point.sure && !isDuct(point.voxel)) return from_m + i * step_m;
    }
    return last_m;
}

}  // namespace stylet::patient
