// Finds the liver's vessels with contrast medium, and separates portal veins from hepatic veins.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

struct FoundVessels {
    Mask vessels;
    // Voxels beside the vessels that score like vessels or slightly less: thin veins, too short or too faint
    // to be certain, but also rims of vessels and noise. A planned path avoids them.
    Mask suspected;
};

// Uses a line filter and region growing. Keeps voxels that score like the inside of a bright tube and are
// connected to a voxel that is certainly vessel. The thresholds are in units of this liver's noise. The wall
// is where the contrast is half of that in the vessel's own centre, which is less bright in narrow vessels.
// The liver's mask may be a few millimetres off. Empty if no contrast medium is visible.
FoundVessels findVessels(const CtVolume&, const Mask& liver);

struct SplitVessels {
    Mask portal, hepatic;            // parts of `vessels`; together all of them
    Mask cava;                       // next to the liver, outside `vessels`; may be empty
    std::vector<std::string> notes;  // a sentence for each structure not found, with the fallback
};

// Separates the trees by a minimum cut. Hepatic seeds are vessels at the vena cava and the widest vessels of
// the upper liver; portal seeds are vessels at the thick blood of the hilum. Elsewhere a voxel
// prefers one of the trees for two reasons: the cheaper path comes from it, or the vessel runs towards its
// root.
SplitVessels splitVessels(const CtVolume&, const Mask& liver, const Mask& vessels);

}  // namespace stylet::modeller
