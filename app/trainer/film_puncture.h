// A film of the skin under a needle: its dimple, the cut, its springing back.
#pragma once

#include "app/trainer/attempt.h"
#include "app/trainer/pictures.h"

namespace stylet::trainer {

// puncture.png and puncture-NNN.png into `out`: `frames` moments about the first cut of the skin by the
// attempt's hand, both looks from the left eye, close up. Nothing where the hand cuts no skin. Throws
// patient::DataError.
void writePuncture(const Attempt&, const StereoView&, int frames, const std::string& title,
                   const std::filesystem::path& out);

}  // namespace stylet::trainer
