#include "app/modeller/wall/bright_rim.h"

#include <algorithm>

#include "app/modeller/image/morphology.h"

namespace stylet::modeller {

double blurReach(const Grid& g, const ScanBlur& blur) {
    // Muscle is above 150 HU up to 1.3 deviations from bone of 1,000 HU, and the bone that was found may be
    // thinner by a voxel. In slices of 3 mm the same paths meet false bone with 1.9 and with 2.6 deviations
    // (seed 421).
    constexpr double kMin_m = 0.002, kDeviations = 2.0;
    return std::max({kMin_m, kDeviations * std::max(blur.within_m, blur.across_m), 1.01 * g.spacing_m.x});
}

Mask brightRim(const CtVolume& ct, const Mask& body, const Mask& bones, double bone_hu,
               const ScanBlur& blur) {
    const double reach_m = blurReach(ct.grid, blur);
    const Mask bright = maskWhere(ct.grid, [&](std::size_t i) {
        return bones.voxels[i] || (body.voxels[i] && ct.voxels[i] >= bone_hu);
    });
    const Mask rim = intersect(subtract(dilated(bones, reach_m), bones), bright);
    return subtract(rim, eroded(closed(bright, reach_m), reach_m));
}

}  // namespace stylet::modeller
