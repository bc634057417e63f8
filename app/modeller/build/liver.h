// The liver, from an atlas prior and the CT itself.
// Based on Boykov and Jolly 2001 (graph cut), Linguraru et al., "Automated segmentation and quantification of
// liver and spleen from CT images using normalized probabilistic atlases and enhancement estimation", Med
// Phys 37, 2010 (prior and intensities of this patient in one cut), and Lankton and Tannenbaum, "Localizing
// region-based active contours", IEEE Trans Image Process 17, 2008 (borders by what lies on either side).
#pragma once

#include <string>
#include <vector>

#include "app/modeller/build/atlas.h"
#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

struct LiverSettings {
    // About this wide are the voxels of the first cut; a bench sweeps it.
    double coarse_m = 0.003;
    // The second cut may move the border so far, on the CT's own grid.
    double band_m = 0.006;
};

struct Liver {
    Mask mask;  // parenchyma, tumours, cysts and the vessels inside; empty where none was found
    double mean_hu = 0.0, sigma_hu = 0.0;  // of the parenchyma, in voxels of the first cut
    std::vector<std::string> notes;
};

// `lungs` and `bones` are on the CT's grid too, all 0 where there are none. A prior with nothing known is
// allowed: then the largest thick organ of soft tissue is taken to be the liver. A body without such a thing
// gives an empty mask and a note.
Liver findLiver(const patient::CtVolume& ct, const Mask& body, const Mask& lungs, const Mask& bones,
                const AtlasPrior&, const LiverSettings& = {});

}  // namespace stylet::modeller
