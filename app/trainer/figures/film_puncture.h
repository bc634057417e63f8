// Film of the skin under a needle: the skin dents, is cut and springs back.
#pragma once

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/view/pictures.h"

namespace stylet::trainer {

// Writes puncture.png and puncture-NNN.png into `out`: `frames` pictures around the first cut of the skin in
// the attempt's trace. They show the closed and the revealed skin close up, from the left eye. Writes nothing
// if the trace never presses on the skin. Throws DataError.
void writePuncture(const Attempt&, const StereoView&, int frames, const std::string& title,
                   const std::filesystem::path& out);

}  // namespace stylet::trainer
