// What the screen evens out: the slow part of a picture's brightness, so that lung and liver fit on it
// together.
#pragma once

#include <span>

namespace stylet::render {

// Line integrals on a lattice of `side` x `side`, < 0 where it is not open. Becomes their mean over the
// surroundings, an eighth of the side to every side, twice; 0 far from anything open.
void smoothOpen(std::span<float> lattice, int side, std::span<float> scratch);

}  // namespace stylet::render
