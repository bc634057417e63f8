// The volume as the ray-march reads it: CT and labels turned into opacity-weighted colours for one look,
// smoothed over a voxel or more. Classifying before interpolation costs one fetch a sample instead of nine,
// and smooth label borders.
#pragma once

#include <cstddef>

#include "render/volume/look.h"

namespace stylet::render {

// RGBA8 texels of planes [z0, z1). A binomial filter takes the steps off label borders; opacities below one
// and a half steps of eight bits become 0, so that empty is exactly empty. Uses `threads` threads.
void classifyPlanes(const patient::Patient&, const Palette&, int z0, int z1, std::byte* rgba, int threads);

}  // namespace stylet::render
