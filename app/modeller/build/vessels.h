// Vessels of the liver as contrast medium shows them, and which of them are portal, which hepatic veins.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// Line filter and region growing: what scores like the inside of a bright tube and hangs together with what
// surely is one, thresholds in units of this liver's own noise; its wall is where blood is half as bright as
// in that vessel's own middle, which in narrow ones is less bright. The liver's mask may be a few millimetres
// off. Empty where contrast medium shows none.
Mask findVessels(const patient::CtVolume&, const Mask& liver);

struct SplitVessels {
    Mask portal, hepatic;            // parts of `vessels`; together all of it
    Mask cava;                       // as far as the liver reaches, outside `vessels`; may be empty
    std::vector<std::string> notes;  // one sentence each on what was not found and what was done instead
};

// By connectivity: from where the vessels come near the cava and from the thick blood at the hilum two fronts
// run along the lumen; narrow contacts, leaps between pieces and ways into thicker vessels cost extra, and
// each voxel falls to the front that reaches it at less cost.
SplitVessels splitVessels(const patient::CtVolume&, const Mask& liver, const Mask& vessels);

}  // namespace stylet::modeller
