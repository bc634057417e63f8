// Internal: shared input of the rules for single organs.
#pragma once

#include <vector>

#include "app/modeller/segmentation/organs.h"

namespace stylet::modeller {

struct OrganScene {
    CtVolume ct;  // the surroundings of the fascia, a part of the scan
    Grid grid;    // of `ct` and all masks and volumes below
    Mask inside;  // the volume inside the fascia
    Mask liver, portal, lung_right, lung_left, gas;
    double left_dome_m;  // height of the left dome, or of the scan's top if there is no left lung
    // HU, mean over three voxels, five in a noisy scan: for organs with a narrow range.
    FloatVolume smooth_hu{};
    FloatVolume unsmoothed_hu{};   // HU of the CT; empty if its voxels are smaller than 1.5 mm
    std::vector<Vec3> canal{};     // the spinal canal's centre in each slice
    double parenchyma_hu = 110.0;  // HU of the liver, or the most frequent value of dense organs
    Mask free{};                   // inside the fascia; not bone, lung, liver or an organ found so far
    // The same, but up to 20 mm beyond the fascia: behind kidney and spleen it is uncertain.
    Mask free_wide{};

    // HU, mean over about 3 mm, 5 mm in a noisy scan: for bright structures with an edge.
    const FloatVolume& edgeHu() const { return unsmoothed_hu.voxels.empty() ? smooth_hu : unsmoothed_hu; }
    // Vector from the canal at the point's height; x to the right, y to the front.
    Vec3 fromCanal(const Index3& i) const { return grid.centre(i) - canal[std::size_t(i.z)]; }
};

// `box`: the part of the scan that organs can lie in. `beside`: where they may lie outside the fascia, on the
// scan's grid.
OrganScene makeScene(const OrganInput&, const VoxelBox& box, const Mask& beside);

// Voxels of `within` with a value in the range.
Mask inRange(const FloatVolume& hu, const Mask& within, double low_hu, double high_hu);

// `core` and the voxels of `passable` within `reach_m` of it, across faces.
Mask growWithin(const Mask& core, const Mask& passable, double reach_m);

struct GreatVessels {
    FoundOrgan aorta, cava;  // empty masks if not found
};
GreatVessels findGreatVessels(const OrganScene&);
// Follows the portal vein for `length_m` from its part in the liver.
FoundOrgan findExtrahepaticPortalVein(const OrganScene&, double length_m);
// The veins from the kidneys to the cava, as far as they show. `free` must include neither.
Mask findRenalVeins(const OrganScene&, const Mask& kidney_right, const Mask& kidney_left, const Mask& cava);

// Finds "stomach and oesophagus", "colon", "small bowel" and "bowel gas", in this order. Their contents are
// darker than `organs_hu`.
std::vector<FoundOrgan> findHollowOrgans(const OrganScene&, double organs_hu);

}  // namespace stylet::modeller
