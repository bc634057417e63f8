// Dilated bile ducts grown beside the labelled portal branches of a patient whose ducts are not segmented.
// Ducts and portal branches share the portal triads (Couinaud); in obstruction the ducts widen from their 2
// mm to 3 to 8 mm. These are virtual: plausible to puncture, never this patient's own.
#pragma once

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

struct DuctSettings {
    double central_radius_m = 0.0035, peripheral_radius_m = 0.0016;
    double gap_m = 0.0005;          // between the duct's wall and the portal branch's
    double beyond_m = 0.015;        // how far a dilated duct reaches past the last labelled portal voxel
    double from_capsule_m = 0.013;  // the outermost parenchyma shows no ducts
    double tip_spacing_m = 0.009;
    double bile_hu = 8.0;
};

struct GrownDucts {
    Mask mask;              // inside the parenchyma only, one 6-connected tree
    FloatVolume coverage;   // share of each voxel that is bile
    int branches = 0;       // tips that were reached
    double length_m = 0.0;  // of all centre lines
    double volume_m3 = 0.0;
};

// `parenchyma`: where a duct may run. `portal`: all of the portal vein; its trunk outside the liver says
// where the hilum is. `vessels`: what a duct keeps clear of, the portal vein among it.
GrownDucts growDucts(const Mask& parenchyma, const Mask& portal, const Mask& vessels, const DuctSettings&);

// Mixes bile into the CT by coverage, keeping the noise of the tissue that was there.
void paintBile(patient::CtVolume&, const GrownDucts&, const Mask& parenchyma, double bile_hu);

}  // namespace stylet::modeller
