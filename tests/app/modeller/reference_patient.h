// A reference patient with the shipped force table.
#pragma once

#include "patient/synth/synth.h"
#include "tests/support/phantom.h"

namespace stylet::test {

inline patient::Package referencePatient(std::uint64_t seed, double spacing_m,
                                         const std::vector<std::string>& variants = {}) {
    patient::synth::SynthSettings settings;
    settings.seed = seed;
    settings.spacing_m = spacing_m;
    settings.defaults = tissueDefaults();
    settings.variants = variants;
    return patient::synth::makeReferencePatient(settings);
}

}  // namespace stylet::test
