// The volume that the ray march reads: CT and labels classified into opacity-weighted colours for one look,
// smoothed over a voxel or more. Classifying before interpolation costs one fetch per sample instead of
// nine and gives smooth label borders.
#pragma once

#include <cstddef>

#include "render/volume/look.h"

namespace stylet::render {

// Writes the RGBA8 texels of planes [z0, z1). A binomial filter smooths the steps of label borders. Opacities
// below one and a half 8-bit steps become 0, so that empty space is exactly 0. Uses `threads` threads.
void classifyPlanes(const patient::Patient&, const Palette&, int z0, int z1, std::byte* rgba, int threads);

}  // namespace stylet::render
