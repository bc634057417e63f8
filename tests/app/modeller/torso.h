// A torso of simple solids with known sizes, in the form that a hospital delivers: CT, label ids and label
// map.
#pragma once

#include "app/modeller/import/import.h"

namespace stylet::test {

struct Torso {
    CtVolume ct;
    Volume<std::int16_t> labels;
    modeller::LabelMap map;
};

// Ids: 7 liver, 465 portal vein, 65 bone, 1 rest of the body. Voxels of 2 x 2 x 3 mm, RAS. A CT table lies
// under the back.
Torso makeTorso();

inline constexpr double kLiver_ml = 4.0 / 3.0 * 3.14159265 * 6.2 * 4.5 * 6.0;

}  // namespace stylet::test
