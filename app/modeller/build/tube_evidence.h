// How much each voxel of a liver looks like the inside of a tube: by its value and by the line filter, both
// in units of what chance alone shows in this liver. Shared by vessels (bright) and ducts (dark).
#pragma once

#include <functional>
#include <vector>

#include "app/modeller/build/tubes.h"

namespace stylet::modeller {

// Parenchyma as a normal distribution, from the histogram's peak and its half width on the side away from the
// tubes, so that neither vessels nor tumours widen it.
struct ParenchymaPeak {
    double mean_hu = 0.0, noise_hu = 1.0;  // noise after the blur of TubeEvidence::contrast_hu
};

struct TubeEvidence {
    VoxelBox box;  // of the CT's grid; all volumes are on this part of it
    Mask liver;
    ParenchymaPeak parenchyma;
    FloatVolume contrast_hu;  // blurred CT less parenchyma, positive in tubes; 0 outside the liver
    // Line response, greatest over the scales, each in units of its own 90th percentile in the liver: noise
    // and texture differ from scale to scale, and this is what they reach by chance.
    FloatVolume line;

    // Noise widths of contrast plus line response, neither counting for more than 6: a bright blob is no
    // vessel, and a dim line none either.
    float score(std::size_t voxel) const;
};

// `radii_m` of the tubes that are looked for; each gives one scale. The liver has at least one voxel.
TubeEvidence tubeEvidence(const patient::CtVolume&, const Mask& liver, TubeKind,
                          const std::vector<double>& radii_m);

// The offsets of one 26-connected piece of a mask, in the order of a flood from its first voxel.
using Piece = std::vector<std::size_t>;
// Those pieces of which `keep` is true.
Mask keepPieces(const Mask&, const std::function<bool(const Piece&)>& keep);

}  // namespace stylet::modeller
