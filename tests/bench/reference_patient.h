// The reference patient of the benches.
#pragma once

#include "patient/synth/synth.h"
#include "tests/support/phantom.h"

namespace stylet::bench {

inline patient::Package referencePatient(double spacing_m,
                                         std::uint64_t seed = patient::synth::SynthSettings{}.seed) {
    patient::synth::SynthSettings settings;
    settings.spacing_m = spacing_m;
    settings.seed = seed;
    settings.defaults = test::tissueDefaults();
    return patient::synth::makeReferencePatient(settings);
}

}  // namespace stylet::bench
