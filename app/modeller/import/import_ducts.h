// Grows dilated bile ducts next to the labelled portal branches of a patient whose ducts are not segmented.
// Ducts and portal branches run together in the portal triads (Couinaud). In obstruction the ducts widen
// from 2 mm to 3 to 8 mm. These ducts are virtual: plausible to puncture, but not the patient's own.
#pragma once

#include <filesystem>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

struct DuctSettings {
    double central_radius_m = 0.0035, peripheral_radius_m = 0.0016;
    double gap_m = 0.0005;          // between the walls of duct and portal branch
    double beyond_m = 0.015;        // reach of a dilated duct beyond the last labelled portal voxel
    double from_capsule_m = 0.013;  // no ducts are visible in the outermost parenchyma
    double tip_spacing_m = 0.009;
    double bile_hu = 8.0;
    std::filesystem::path source;  // file or folder of the labels; named in errors
};

struct GrownDucts {
    Mask mask;              // inside the parenchyma only, one 6-connected tree
    FloatVolume coverage;   // share of each voxel that is bile
    int branches = 0;       // branch tips reached
    double length_m = 0.0;  // of all centre lines
    double volume_m3 = 0.0;
};

// `parenchyma`: where ducts may run. `portal`: the whole portal vein; its trunk outside the liver shows the
// position of the hilum. `vessels`: everything that ducts must avoid, including the portal vein. Throws
// ImportError if there is no liver or no portal vein inside it.
GrownDucts growDucts(const Mask& parenchyma, const Mask& portal, const Mask& vessels, const DuctSettings&);

// Blends bile into the CT by coverage. Keeps the noise of the original tissue.
void paintBile(CtVolume&, const GrownDucts&, const Mask& parenchyma, double bile_hu);

}  // namespace stylet::modeller
