// Internal: what the rules for single organs look at.
#pragma once

#include <vector>

#include "app/modeller/build/organs.h"

namespace stylet::modeller {

struct OrganScene {
    const OrganInput& in;
    patient::Grid grid;
    FloatVolume fine;                  // HU, a mean over about 3 mm: for what is bright and has an edge
    FloatVolume calm;                  // and over three voxels at least: for what is told by a narrow range
    std::vector<patient::Vec3> canal;  // the spinal canal's middle at each slice
    double parenchyma_hu = 110.0;      // of the liver, or the commonest value of dense organs
    Mask free;                         // inside the fascia, not bone, lung, liver or organ found so far
    Mask free_wide;  // the same, and some way out through it: behind kidney and spleen it is not sure

    // From the canal at the point's height; x to the right, y to the front.
    patient::Vec3 fromCanal(const patient::Index3& i) const {
        return grid.centre(i) - canal[std::size_t(i.z)];
    }
};

OrganScene makeScene(const OrganInput&);

// Voxels of `within` whose value lies in a range.
Mask inRange(const FloatVolume& hu, const Mask& within, double low_hu, double high_hu);

// `core` and what of `passable` lies within `reach_m` of it, over faces.
Mask regrown(const Mask& core, const Mask& passable, double reach_m);

FoundOrgan findAorta(const OrganScene&);
FoundOrgan findCava(const OrganScene&, const Mask& aorta);

// "bowel gas", "stomach and oesophagus", "colon"
std::vector<FoundOrgan> findHollow(const OrganScene&);

}  // namespace stylet::modeller
