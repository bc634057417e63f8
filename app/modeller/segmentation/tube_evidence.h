// Measures how much each voxel of a liver looks like the inside of a tube, by its value and by the line
// filter, both in units of this liver's random variation. Used for vessels (bright) and ducts (dark).
#pragma once

#include <functional>
#include <vector>

#include "app/modeller/segmentation/tubes.h"

namespace stylet::modeller {

// Parenchyma as a normal distribution: the histogram's peak, and its half width on the side away from the
// tubes, so that neither vessels nor tumours widen it.
struct ParenchymaPeak {
    double mean_hu = 0.0, noise_hu = 1.0;  // noise after the blur of TubeEvidence::contrast_hu
};

struct TubeEvidence {
    VoxelBox box;  // on the CT's grid; all volumes cover this part of it
    Mask liver;
    ParenchymaPeak parenchyma;
    FloatVolume contrast_hu;  // blurred CT minus parenchyma, positive in tubes; 0 outside the liver
    // Maximum line response over the scales, each in units of its own 90th percentile in the liver. Noise
    // and texture differ between scales, and this percentile is what they reach by chance.
    FloatVolume line;

    // Contrast in noise widths plus line response. Each is limited to 6, so that neither a bright blob nor a
    // dim line scores as a vessel.
    float score(std::size_t voxel) const;
};

// `radii_m`: radii of the tubes to find; one scale per radius. The liver must have at least one voxel.
TubeEvidence tubeEvidence(const CtVolume&, const Mask& liver, TubeKind, const std::vector<double>& radii_m);

// The offsets of one 26-connected piece of a mask, in flood-fill order from its first voxel.
using Piece = std::vector<std::size_t>;
// Keeps the pieces for which `keep` returns true.
Mask filterComponents(const Mask&, const std::function<bool(const Piece&)>& keep);

}  // namespace stylet::modeller
