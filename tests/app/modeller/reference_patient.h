// Reference patients with the shipped force table.
#pragma once

#include "patient/synth/synth.h"
#include "tests/support/phantom.h"

namespace stylet::test {

inline patient::Package referencePatient(std::uint64_t seed, double spacing_m,
                                         const std::vector<std::string>& variants = {}, bool motion = true) {
    patient::synth::SynthSettings settings;
    settings.motion = motion;
    settings.seed = seed;
    settings.spacing_m = spacing_m;
    settings.defaults = tissueDefaults();
    settings.variants = variants;
    return patient::synth::makeReferencePatient(settings);
}

// The same voxels without the motion, which takes half of the time in coarse voxels.
inline patient::Package stillPatient(std::uint64_t seed, double spacing_m,
                                     const std::vector<std::string>& variants = {}) {
    return referencePatient(seed, spacing_m, variants, false);
}

}  // namespace stylet::test
