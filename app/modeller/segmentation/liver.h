// Segments the liver from an atlas prior and the CT.
// Based on Boykov and Jolly 2001 (graph cut), Linguraru et al., "Automated segmentation and quantification
// of liver and spleen from CT images using normalized probabilistic atlases and enhancement estimation",
// Med Phys 37, 2010 (prior and this patient's intensities in one cut), and Lankton and Tannenbaum,
// "Localizing region-based active contours", IEEE Trans Image Process 17, 2008 (borders from local means on
// both sides).
#pragma once

#include <string>
#include <vector>

#include "app/modeller/image/scan_blur.h"
#include "app/modeller/image/voxel_tools.h"
#include "app/modeller/segmentation/atlas.h"

namespace stylet::modeller {

struct LiverSettings {
    // Approximate voxel size of the first cut; a bench sweeps it.
    double coarse_m = 0.003;
    // Maximum distance by which the second cut, on the CT's own grid, may move the border.
    double band_m = 0.006;
    double blur_m = kUsualBlur_m;  // standard deviation of the scan's blur within its slices
};

struct Liver {
    Mask mask;  // parenchyma, tumours, cysts and the vessels inside; empty if not found
    double mean_hu = 0.0, sigma_hu = 0.0;  // of the parenchyma, at the voxel size of the first cut
    std::vector<std::string> notes;
};

// `lungs` and `bones` are also on the CT's grid, and all 0 if there are none. Without a known prior, the
// largest thick organ of soft tissue is taken as the liver. If there is none, returns an empty mask and a
// note.
Liver findLiver(const CtVolume& ct, const Mask& body, const Mask& lungs, const Mask& bones, const AtlasPrior&,
                const LiverSettings& = {});

// Dense pieces that the liver surrounds and that come within 5 mm of it. Excludes stones in ducts outside the
// liver, which the liver surrounds at a distance.
Mask calcifiedLiver(const Mask& dense, const Mask& liver);

}  // namespace stylet::modeller
