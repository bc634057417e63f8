// A coarse reference patient with its true labels. Fast enough for every build type.
#pragma once

#include <initializer_list>

#include "app/modeller/image/morphology.h"
#include "app/modeller/image/scan_blur.h"
#include "app/modeller/import/import_body.h"
#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/bones.h"
#include "app/modeller/segmentation/lungs.h"
#include "patient/synth/labels.h"
#include "tests/app/modeller/reference_patient.h"

namespace stylet::test {

// Seed 1 at 2.5 mm. Created once.
inline const patient::Package& seededTorso() {
    static const patient::Package package = stillPatient(1, 0.0025);
    return package;
}

inline const modeller::Mask& seededBody() {
    static const modeller::Mask body = modeller::bodyMask(seededTorso().ct);
    return body;
}

// As found in the CT.
inline const modeller::Bones& seededBones() {
    static const modeller::Bones bones =
        modeller::findBones(seededTorso().ct, seededBody(), modeller::ScanBlur{});
    return bones;
}

inline const modeller::Lungs& seededLungs() {
    static const modeller::Lungs lungs = modeller::findLungs(seededTorso().ct, seededBody());
    return lungs;
}

inline modeller::Mask seededTruth(std::initializer_list<patient::synth::Id> ids) {
    const LabelVolume& labels = seededTorso().labels;
    const patient::synth::IdSet set = patient::synth::anyOf(ids);
    return modeller::maskWhere(
        labels.grid, [&](std::size_t i) { return patient::synth::contains(set, labels.voxels[i]); });
}

inline double diceWithTruth(std::initializer_list<patient::synth::Id> ids, const modeller::Mask& found) {
    return modeller::compare(seededTruth(ids), found).dice;
}

}  // namespace stylet::test
