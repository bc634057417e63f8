// Finds each lung, and the air in the body that is not lung.
// Cf. Hu, Hoffman and Reinhardt, "Automatic lung segmentation for accurate quantitation of volumetric X-ray
// CT images", IEEE TMI 20, 2001. Lung and gas are separated by density, not by connectivity: the diaphragm
// is only two millimetres thick and does not always separate them.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/image/voxel_tools.h"
#include "app/modeller/motion/dome.h"

namespace stylet::modeller {

struct Lungs {
    Mask right, left;  // including their vessels; without heart, mediastinum and the trunks at the roots
    Mask airways;      // trachea and bronchi, where visible as pure air
    Mask gas;          // any other air within the body
    // The base of each lung: height of the tissue below it over each column (x, y). NaN if there is none or
    // if the section ends within the lung.
    DomeMap base_right, base_left;
    std::vector<std::string> notes;
};

// Computes the base of one lung.
DomeMap lungBase(const Mask& lung, const Mask& body);

// If a lung is outside the section, its mask is empty and a note says so. `body` is the result of bodyMask().
Lungs findLungs(const CtVolume&, const Mask& body);

}  // namespace stylet::modeller
