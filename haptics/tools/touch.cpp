#include "haptics/tools/touch.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/spline.h"
#include "base/traversal.h"

namespace stylet::haptics {

using patient::Patient;
using patient::Tissue;

namespace {

constexpr double kAirInFront_m = 0.002;
constexpr double kSecant_m = 0.006;
constexpr double kMinSlope = 0.25;   // with a smaller gradient of level_m, the skin's normal is undefined
constexpr int kShellSmoothings = 2;  // passes of 1/4, 1/2, 1/4; each adds 0.5 nodes squared to the variance
constexpr double kMinCover_m = 0.0005;  // one voxel of skin on bone
// Signed distances (level_m) of the nodes that a look-up may need: inward to the greatest pressing depth,
// outward as far as the spline reaches. Nodes within kShell_m of the skin are computed voxel by voxel. The
// others take the values of the nearest point on the skin.
constexpr double kMinLevel_m = -0.056, kMaxLevel_m = 0.006, kShell_m = 0.004;

}  // namespace

Layers computeLayers(const Patient& patient, const Vec3& skin_m, const Vec3& inward) noexcept {
    const Vec3 from = skin_m - kAirInFront_m * inward;
    const double path_m = 2.0 * kAirInFront_m + kTouchDepth_m;
    Layers layers;
    double depth_m = 0.0;   // from the first tissue
    double young_pa = 0.0;  // keeps its value beyond the image's edge
    patient::TrackFlags track;
    for (VoxelWalk w(patient.grid(), from, from + path_m * inward); !w.done(); w.next()) {
        const patient::TissueSample x = patient.at(w.voxel(), track);
        if (depth_m == 0.0 && x.tissue == Tissue::air && x.label == 0) continue;
        if (patient.grid().contains(w.voxel()))
            young_pa = patient.package().elasticity[std::size_t(x.tissue)].young_pa;
        if (std::isinf(young_pa)) {
            layers.cover_m = depth_m;
            break;
        }
        const double h_m = std::min((w.end() - w.begin()) * path_m, kTouchDepth_m - depth_m);
        layers.compliance_m_per_pa += h_m / young_pa;
        depth_m += h_m;
        track = patient.flagsAfterEntering(x, track);
        if (depth_m >= kTouchDepth_m) break;
    }
    return layers;
}

namespace {

// Computes `stiffness_n_per_m3` and `bone_per_m` of one node. Leaves them 0 where the skin's normal is
// undefined.
void computeNode(const Patient& patient, const patient::Skin& skin, const Vec3& at_m, float* node) noexcept {
    const Vec3 foot = patient::nearestSkinPoint(skin, at_m);
    const Vec3 normal = patient::skinAt(skin, foot).normal;
    const double length = glm::length(normal);
    if (!(length > kMinSlope)) return;
    // Beyond the image's edge its last slices continue.
    const Vec3 last_m = patient.grid().centre(patient.grid().dims - 1);
    const Vec3 within_m = glm::clamp(foot, patient.grid().origin_m, last_m);
    const Layers layers = computeLayers(patient, within_m, normal / -length);
    const double thin_m_per_pa =
        kMinCover_m / patient.package().elasticity[std::size_t(Tissue::skin)].young_pa;
    node[1] = float(1.0 / std::max(layers.compliance_m_per_pa, thin_m_per_pa));
    node[2] = float(1.0 / std::max(layers.cover_m, kMinCover_m));
}

// Tissue beside a point carries load too, so stiffness and bone are averaged over neighbouring nodes of the
// shell. Without that, the edge of a rib would feel stiffer than its middle.
class ShellSmoother {
  public:
    ShellSmoother(TouchMap& map, int threads) : map_(map), threads_(threads) {
        for (std::vector<float>* plane : {&weight_, &stiffness_, &bone_})
            plane->assign(map.grid.voxelCount(), 0.0f);
        for (std::size_t i = 0; i < weight_.size(); ++i) {
            const float* const node = map.nodes.data() + 3 * i;
            if (node[1] > 0.0f) weight_[i] = 1.0f, stiffness_[i] = node[1], bone_[i] = node[2];
        }
    }

    void run() {
        for (int pass = 0; pass < kShellSmoothings; ++pass)
            for (int axis = 0; axis < 3; ++axis)
                for (std::vector<float>* plane : {&weight_, &stiffness_, &bone_})
                    smoothAlong(*plane, axis);
        for (std::size_t i = 0; i < weight_.size(); ++i) {
            float* const node = map_.nodes.data() + 3 * i;
            if (node[1] > 0.0f) node[1] = stiffness_[i] / weight_[i], node[2] = bone_[i] / weight_[i];
        }
    }

  private:
    void smoothAlong(std::vector<float>& plane, int axis) {
        parallelLines(threads_, map_.grid.dims, axis, plane.data(),
                      [](float* p, std::size_t stride, std::size_t count) {
                          float before = 0.0f;
                          for (std::size_t i = 0; i < count; ++i, p += stride) {
                              const float here = p[0], after = i + 1 < count ? p[stride] : 0.0f;
                              p[0] = 0.25f * before + 0.5f * here + 0.25f * after;
                              before = here;
                          }
                      });
    }

    TouchMap& map_;
    int threads_;
    std::vector<float> weight_, stiffness_, bone_;
};

// Linear interpolation between the shell nodes around the foot point on the skin.
void interpolateNode(const TouchMap& map, const patient::Skin& skin, const Vec3& at_m, float* node) noexcept {
    const Vec3 v = map.grid.toVoxels(patient::nearestSkinPoint(skin, at_m));
    const Index3 low = glm::clamp(Index3(glm::floor(v)), Index3(0), map.grid.dims - 2);
    const Vec3 share = glm::clamp(v - Vec3(low), Vec3(0.0), Vec3(1.0));
    double weights = 0.0, stiffness = 0.0, bone = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const Index3 up{corner & 1, corner >> 1 & 1, corner >> 2};
        const float* const n = map.nodes.data() + 3 * map.grid.offset(low + up);
        if (std::fabs(double(n[0])) > kShell_m) continue;
        const double weight = (up.x ? share.x : 1.0 - share.x) * (up.y ? share.y : 1.0 - share.y) *
                              (up.z ? share.z : 1.0 - share.z);
        weights += weight, stiffness += weight * double(n[1]), bone += weight * double(n[2]);
    }
    if (!(weights > 0.0)) return;
    node[1] = float(stiffness / weights);
    node[2] = float(bone / weights);
}

}  // namespace

TouchMap makeTouchMap(const Patient& patient, const patient::Skin& skin, int threads) {
    TouchMap map{skin.level_m.grid, {}};
    const Grid& grid = map.grid;
    map.nodes.assign(3 * grid.voxelCount(), 0.0f);
    const auto forEachNode = [&](const auto& visit) {
        parallelFor(threads, std::size_t(grid.dims.z), [&](std::size_t z) {
            Index3 i{0, 0, int(z)};
            for (i.y = 0; i.y < grid.dims.y; ++i.y)
                for (i.x = 0; i.x < grid.dims.x; ++i.x)
                    visit(i, map.nodes.data() + 3 * grid.offset(i));
        });
    };
    forEachNode([&](const Index3& i, float* node) {
        node[0] = skin.level_m[i];
        if (std::fabs(double(node[0])) <= kShell_m) computeNode(patient, skin, grid.centre(i), node);
    });
    ShellSmoother(map, threads).run();
    forEachNode([&](const Index3& i, float* node) {
        const double level_m = double(node[0]);
        if (level_m < kMinLevel_m || level_m > kMaxLevel_m || std::fabs(level_m) <= kShell_m) return;
        interpolateNode(map, skin, grid.centre(i), node);
    });
    return map;
}

TouchMap makeTouchMap(const Patient& patient) {
    return makeTouchMap(patient, patient::makeSkin(patient, 2), 2);
}

TouchPoint touchAt(const TouchMap& map, const Vec3& reference_m) noexcept {
    const auto s = sampleSpline<3>(map.grid, map.nodes.data(), reference_m);
    TouchPoint t{s.value[0] + s.beyond_m, s.value[1], s.value[2], s.slope[0], s.slope[1], s.slope[2]};
    if (!(s.value[0] < -kDeepestTip_m)) return t;
    // The nodes end there. Deeper, the layers are those above, which have the same foot point.
    const Vec3 up_m = (-kDeepestTip_m - s.value[0]) * unitOr(t.level_slope, Vec3(0.0));
    const auto above = sampleSpline<3>(map.grid, map.nodes.data(), reference_m + up_m);
    t.stiffness_n_per_m3 = above.value[1], t.stiffness_slope = above.slope[1];
    t.bone_per_m = above.value[2], t.bone_slope = above.slope[2];
    return t;
}

SkinPressure computePressure(const TouchPoint& t, double stiffest) noexcept {
    const double d = -t.level_m;
    if (!(d > 0.0)) return {};
    const bool thin = t.stiffness_n_per_m3 * kMaxStiffening >= stiffest;
    const double k = thin ? stiffest / kMaxStiffening : t.stiffness_n_per_m3;
    SkinPressure p;
    double over_k, over_bone;  // derivatives of the energy with respect to the stiffness and to 1 / cover
    const double strain = d * t.bone_per_m;
    if (strain <= kMaxStrain) {
        const double left = 1.0 / (1.0 - strain);
        over_k = 0.5 * d * d * left;
        over_bone = over_k * k * d * left;
        p.pressure_pa = k * d * (1.0 - 0.5 * strain) * left * left;
        p.energy_j_per_m2 = k * over_k;
    } else {
        const double h = 1.0 / t.bone_per_m, hard = d - kMaxStrain * h;
        over_k = 0.25 * h * h + 1.5 * h * hard;
        over_bone = h * h * (0.25 * k * h + (0.5 * stiffest - 1.5 * k) * hard);
        p.pressure_pa = 1.5 * k * h + stiffest * hard;
        p.energy_j_per_m2 = k * over_k + 0.5 * stiffest * hard * hard;
    }
    p.push_n_per_m2 = p.pressure_pa * t.level_slope - over_bone * t.bone_slope;
    if (!thin) p.push_n_per_m2 -= over_k * t.stiffness_slope;
    return p;
}

Vec3 skinDisplacement(const BreathingSkin& skin, const patient::Surrogate& then,
                      const Vec3& skin_reference_m) noexcept {
    if (skin.motion.empty() || then == skin.breath) return Vec3(0.0);
    return patient::deformedFromReference(skin.motion, skin.breath, skin_reference_m) -
           patient::deformedFromReference(skin.motion, then, skin_reference_m);
}

LocalBreathingMap breathingMapAt(const BreathingSkin& skin, const Vec3& deformed_m) noexcept {
    return {deformed_m, patient::referenceFromDeformed(skin.motion, skin.breath, deformed_m), Mat3(1.0)};
}

void addSlope(LocalBreathingMap& c, const BreathingSkin& skin, const Mat3& frame) noexcept {
    if (skin.motion.empty()) return;
    Mat3 along;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 at_m = c.at_m + kSecant_m * frame[axis];
        const Vec3 there_m = patient::referenceFromDeformed(skin.motion, skin.breath, at_m);
        along[axis] = (there_m - c.at_reference_m) / kSecant_m;
    }
    c.slope = along * glm::transpose(frame);
}

Vec3 unitOr(const Vec3& v, const Vec3& otherwise) noexcept {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : otherwise;
}

bool dragProxy(Vec3& proxy_m, const Vec3& point_m, const Vec3& normal, double most_m,
               Vec3& stretch_m) noexcept {
    stretch_m = point_m - proxy_m;
    stretch_m -= glm::dot(stretch_m, normal) * normal;
    const double length_m = glm::length(stretch_m);
    if (length_m <= most_m) return false;
    stretch_m *= most_m / length_m;
    proxy_m = point_m - stretch_m;
    return true;
}

}  // namespace stylet::haptics
