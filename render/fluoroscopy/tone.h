// The slow part of a picture's brightness. The screen removes a share of it, so that lung and liver fit on
// it together.
#pragma once

#include <span>

namespace stylet::render {

// `lattice`: line integrals on `side` x `side` cells, < 0 where it is not open. Replaces each by the mean
// over its surroundings (an eighth of the side in each direction), twice. 0 far from anything open.
void smoothOpen(std::span<float> lattice, int side, std::span<float> scratch);

}  // namespace stylet::render
