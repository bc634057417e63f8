// Where the tissue of a chest slides: the pleura of a 4D CT, found without labels.
#pragma once

#include "app/modeller/phases.h"

namespace stylet::modeller {

// What lies within the ribs, on the grid of the phases. Beside lung the outermost air of any phase is the
// wall; below it the wall goes on as it ran, inside the ribs. Open toward the mediastinum and the picture's
// ends; vertebrae are outside. Throws ImportError where there is no lung.
Mask chestCavity(const std::vector<Phase>&);

// Distance to the mask's surface in metres, < 0 inside.
FloatVolume levelOf(const Mask&);

}  // namespace stylet::modeller
