// The low-frequency part of a picture's brightness. The screen removes a share of it, so that its grey range
// shows lung and liver together.
#pragma once

#include <span>

namespace stylet::render {

// `lattice`: line integrals on `side` x `side` cells, < 0 behind the blades. Replaces each twice by the mean
// of the open cells around it (an eighth of the side in each direction). Cells far from any open cell become
// 0.
void smoothOpen(std::span<float> lattice, int side, std::span<float> scratch);

}  // namespace stylet::render
