// A breathing model for a patient of whom there is one CT: a template's travel inside a cavity fitted to the
// labels.
#pragma once

#include "app/modeller/import_fascia.h"
#include "patient/breathing.h"

namespace stylet::modeller {

// Ellipses that hold the moving organs (liver, lungs, ...) and leave the ribs outside, as far as ellipses
// can. Full travel over the liver's height, `travel_m` from end-exhale to end-inhale (caudal), fading to rest
// above and below.
patient::BreathingModel fitBreathing(const WallSurface&, const Mask& liver, const Mask& moving,
                                     const Mask& bones, double travel_m);

}  // namespace stylet::modeller
