#include "app/modeller/wall/costal_cartilage.h"

#include <algorithm>

#include "app/modeller/image/morphology.h"
#include "app/modeller/wall/bone_border.h"
#include "app/modeller/wall/bright_rim.h"

namespace stylet::modeller {

Mask costalCartilage(const CtVolume& ct, const Mask& body, const ScanBlur& blur, const Mask& inside,
                     const RibCage& bones) {
    // Muscle is below 75 HU. An adult's cartilage is at 90 to 130 HU, and more where calcified. In wide
    // voxels the edges of cartilage look like muscle, and muscle beside a rib looks like cartilage.
    constexpr float kLow_hu = 78.0f, kHigh_hu = 500.0f;
    // Beyond the core: muscle at the border of cartilage must not feel hard and count as a hit. From 84 to 92
    // HU no planned path of seed 71 meets false cartilage; a higher value makes the cartilage thinner.
    constexpr float kSure_hu = 86.0f;
    constexpr double kWidest_m = 0.00125;
    constexpr double kSkin_m = 0.006, kThick_m = 0.0025, kJoin_m = 0.004, kMin_ml = 0.5, kMinDense_ml = 0.03,
                     kRimReach_m = 0.003;
    const Grid& g = ct.grid;
    if (g.spacing_m.x > kWidest_m) return Mask(g);
    FloatVolume smooth = boxMean(toFloat(ct), 1);
    const Mask taken = unite(unite(inside, bones.all), dilated(bones.spine, 0.010));
    Mask found = eroded(body, kSkin_m);
    for (std::size_t i = 0; i < found.voxels.size(); ++i)
        found.voxels[i] =
            found.voxels[i] && !taken.voxels[i] && smooth.voxels[i] > kLow_hu && smooth.voxels[i] < kHigh_hu;
    // Cartilage begins where the ribs end, in front of the body's middle. Behind it are muscles, and also
    // kidneys where the fascia is inaccurate.
    const VoxelBox box = boundingBox(body);
    const VoxelBox back{Index3(0), {g.dims.x - 1, (box.low.y + box.high.y) / 2, g.dims.z - 1}};
    forEachVoxel(back, [&](const Index3& i) { found[i] = 0; });
    // A rib's blurred rim is as dense as cartilage: count it only as part of a thicker piece.
    const Mask rim = dilated(bones.all, 1.01 * g.spacing_m.x);
    const Mask core = opened(subtract(found, rim), std::max(kThick_m, 1.01 * g.spacing_m.x));
    const Mask sure =
        maskWhere(g, [&](std::size_t i) { return found.voxels[i] && smooth.voxels[i] > kSure_hu; });
    smooth = {};  // the memory is needed
    found = unite(core, intersect(sure, dilated(core, 2.0 * g.spacing_m.x)));
    found = floodFill(intersect(dilated(bones.ends, kJoin_m), found), found);
    // The blurred rim of bone and of calcified cartilage is as dense as cartilage, too.
    Mask dense = maskWhere(g, [&](std::size_t i) { return found.voxels[i] && ct.voxels[i] > kBone_hu; });
    removeSmallComponents(dense, kMinDense_ml, Connectivity::corners);
    const Mask clear = withoutBlurredRim({ct, body, blur}, unite(found, bones.all), bones.canal);
    found = subtract(found, subtract(dilated(unite(dense, bones.all), kRimReach_m), clear));
    removeSmallComponents(found, kMin_ml);
    return found;
}

Mask cartilageRim(const CtVolume& ct, const Mask& body, const ScanBlur& blur, const Mask& cartilage,
                  const Mask& taken, double bone_hu) {
    constexpr std::int16_t kDensest_hu = 500;
    if (countVoxels(cartilage) == 0) return cartilage;
    const Mask rim = brightRim(ct, body, cartilage, bone_hu, blur);
    return maskWhere(rim.grid, [&](std::size_t i) {
        return rim.voxels[i] && !taken.voxels[i] && ct.voxels[i] < kDensest_hu;
    });
}

}  // namespace stylet::modeller
