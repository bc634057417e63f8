// The lungs, each for itself, and what air in the body belongs to no lung.
// Cf. Hu, Hoffman and Reinhardt, "Automatic lung segmentation for accurate quantitation of volumetric X-ray
// CT images", IEEE TMI 20, 2001; lung and gas are told apart by density, not by connection: the diaphragm,
// two millimetres of it, does not always separate them.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/dome.h"
#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

struct Lungs {
    Mask right, left;  // with their vessels; without heart, mediastinum and the roots' trunks
    Mask airways;      // trachea and bronchi as far as they show as pure air
    Mask gas;          // any other air within the body
    // The lung's base: height of the tissue below it over each column (x, y), NaN where there is none or the
    // section ends within the lung.
    DomeMap base_right, base_left;
    std::vector<std::string> notes;
};

// The base of one lung.
DomeMap lungBase(const Mask& lung, const Mask& body);

// A lung outside the section leaves its mask empty and a note. `body` as bodyMask() has it.
Lungs findLungs(const patient::CtVolume&, const Mask& body);

}  // namespace stylet::modeller
