// A coarse reference patient with its true labels. Fast enough for every build type.
#pragma once

#include <initializer_list>

#include "app/modeller/import/import_body.h"
#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/morphology.h"
#include "patient/synth/labels.h"
#include "patient/synth/synth.h"
#include "tests/support/phantom.h"

namespace stylet::test {

// Seed 1 at 2.5 mm. Created once.
inline const patient::Package& seededTorso() {
    static const patient::Package package = [] {
        patient::synth::SynthSettings s;
        s.seed = 1;
        s.spacing_m = 0.0025;
        s.defaults = tissueDefaults();
        return patient::synth::makeReferencePatient(s);
    }();
    return package;
}

inline const modeller::Mask& seededBody() {
    static const modeller::Mask body = modeller::bodyMask(seededTorso().ct);
    return body;
}

inline modeller::Mask seededTruth(std::initializer_list<patient::synth::Id> ids) {
    const LabelVolume& labels = seededTorso().labels;
    const patient::synth::IdSet set = patient::synth::anyOf(ids);
    modeller::Mask m(labels.grid);
    for (std::size_t i = 0; i < m.voxels.size(); ++i)
        m.voxels[i] = patient::synth::holds(set, labels.voxels[i]);
    return m;
}

inline double diceOf(std::initializer_list<patient::synth::Id> ids, const modeller::Mask& found) {
    return modeller::compare(seededTruth(ids), found).dice;
}

}  // namespace stylet::test
