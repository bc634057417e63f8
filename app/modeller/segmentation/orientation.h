// Refuses a scan whose file states wrong axes. All masks of a call are on one grid. The error names `scan`, a
// file or folder. Exchanged sides are refused by alignAtlases().
#pragma once

#include <filesystem>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Throws ImportError if the lungs lie more than 3 cm below the middle of the body. Does nothing if there are
// no lungs. A scan from the head to the liver, with raised arms, may be refused although it is right.
void checkUpright(const Mask& body, const Mask& lungs, const std::filesystem::path& scan);

// Throws ImportError if the bones lie in front of the middle of the body. Does nothing if there are no bones.
void checkFrontAndBack(const Mask& body, const Mask& bones, const std::filesystem::path& scan);

}  // namespace stylet::modeller
