// The patient's surface as a smooth signed distance: what a hand, a probe or a blade can touch.
// Defined in the reference frame. For a breathing patient, look up the level at referenceFromDeformed(p).
#pragma once

#include "patient/package/package.h"

namespace stylet::patient {

// Nodes of a quadratic B-spline, about kSkinNode_m apart: distance to the border between body and outer air,
// < 0 in the body. Values are averages over the voxels around a node, smoothed over about 5 mm, because
// voxels cut a nearly flat surface into terraces 10 mm wide. Lung and gas count as body. The border of the
// image is not skin: the body continues there.
struct Skin {
    Volume<float> level_m;
};

inline constexpr double kSkinNode_m = 0.002;

// Called while loading: 1.4 s on one thread for 15 million voxels. The result does not depend on the
// thread count.
Skin makeSkin(const Patient&, int threads);

struct SkinPoint {
    double level_m = 0.0;        // outside the image: the level at its edge plus the distance to that edge
    Vec3 normal{0.0, 0.0, 0.0};  // gradient of the level: outward, length about 1
};
// Any thread. noexcept, no allocation, about 0.04 us.
SkinPoint skinAt(const Skin&, const Vec3& reference_m) noexcept;

// The nearest point on the skin, by three Newton steps along the gradient. Any thread. noexcept.
Vec3 nearestSkinPoint(const Skin&, const Vec3& reference_m) noexcept;

}  // namespace stylet::patient
