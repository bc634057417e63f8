// The bones: found by their cortex, filled with their marrow, told apart by where they lie.
// Contrast medium reaches the values of spongy bone in vessels, heart and kidneys, never those of cortex.
// Cf. Staal, van Ginneken and Viergever, "Automatic rib segmentation and labeling in computed tomography
// scans", Med. Image Anal. 11, 2007, for the order of the steps: spine first, ribs from there.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

struct Rib {
    bool right = true;
    int number = 0;         // 1 to 12; counted as `Bones::notes` says
    bool at_spine = false;  // else a piece whose back part lies above the section
    double volume_ml = 0.0;
    std::vector<patient::Vec3> centre_line_m;  // from the spine to the front, about 5 mm apart
};

struct Bones {
    Mask all;  // what follows, without canal and cartilage
    Mask spine, canal, ribs_right, ribs_left, sternum;
    Mask other;                          // pelvis, scapula, arm: no part of the cage
    Mask cartilage;                      // discs and costal cartilage, as far as they plainly show
    std::vector<Rib> ribs;               // right before left, from the head down
    std::vector<patient::Vec3> canal_m;  // the canal's centre, slice by slice where it shows
    std::vector<std::string> notes;
};

Bones findBones(const patient::CtVolume&, const Mask& body);

// The ribs' cartilage, as far as it is plainly denser than muscle: what lies outside the fascia (`inside` is
// what that encloses), below the skin's fat, and joins a rib or the sternum. Empty where voxels are wider
// than 1.25 mm.
Mask costalCartilage(const patient::CtVolume&, const Mask& body, const Mask& inside, const Bones&);

}  // namespace stylet::modeller
