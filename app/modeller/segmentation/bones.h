// Finds the bones by their cortex, fills in their marrow and identifies them by position. Contrast medium
// in vessels, heart and kidneys is as bright as spongy bone, but at 120 kV never as bright as cortex.
// Cf. Staal, van Ginneken and Viergever, "Automatic rib segmentation and labeling in computed tomography
// scans", Med. Image Anal. 11, 2007, for the order of the steps: spine first, then ribs.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/image/scan_blur.h"
#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

struct Rib {
    bool right = true;
    int number = 0;         // 1 to 12; `Bones::notes` says how they were counted
    bool at_spine = false;  // false: a piece whose back part is above the section
    double volume_ml = 0.0;
    std::vector<Vec3> centre_line_m;  // from the spine to the front, about 5 mm apart
};

struct Bones {
    Mask all;  // union of the following, without canal and cartilage
    Mask spine, canal, ribs_right, ribs_left, sternum;
    Mask other;                 // pelvis, scapula, arm: not part of the rib cage
    Mask cartilage;             // discs and costal cartilage, where clearly visible
    std::vector<Rib> ribs;      // right before left, from the head down
    std::vector<Vec3> canal_m;  // the canal's centre in each slice where it is visible
    std::vector<std::string> notes;
};

Bones findBones(const CtVolume&, const Mask& body, const ScanBlur&);

}  // namespace stylet::modeller
