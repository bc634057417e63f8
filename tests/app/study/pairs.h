// Pairs with known differences: slabs with a displaced fascia, and a reference patient with displaced labels.
#pragma once

#include "app/study/study.h"
#include "patient/synth/synth.h"
#include "tests/support/phantom.h"

namespace stylet::test {

inline const study::PairFiles kTestFiles{"made", "truth", "built"};

// Skin, soft tissue, fascia, liver and duct in voxels of 0.5 mm. The fascia begins at `fascia_m`. The duct
// always begins at 61 mm.
inline patient::Package slabs(double fascia_m) {
    using enum patient::Tissue;
    return makeSlabs({{skin, 0.002},
                      {soft, fascia_m - 0.002},
                      {fascia, 0.001},
                      {liver, 0.060 - fascia_m},
                      {duct, 0.004},
                      {liver, 0.020}},
                     0.0005);
}

inline void markAsBuilt(patient::Package& package) {
    for (patient::Label& label : package.label_table)
        label.provenance = "automatic: " + label.name;
    package.name = "built";
    package.provenance = "built from a CT alone; atlases: none";
}

inline study::Pair slabPair(double full_fascia_m, double partial_fascia_m,
                            study::FoundLabels labels = study::FoundLabels::partial) {
    patient::Package full = slabs(full_fascia_m), partial = slabs(partial_fascia_m);
    partial.ct = full.ct;
    markAsBuilt(partial);
    return study::makePair(kTestFiles, full, partial, labels);
}

// A path perpendicular to the slabs, from the first skin voxel to the centre of the duct.
inline patient::PlannedPath slabPath() {
    patient::PlannedPath path;
    path.entry_m = path.entry_reference_m = {0.00025, 0.0, 0.0};
    path.target_m = path.target_reference_m = {0.063, 0.0, 0.0};
    path.length_m = 0.06275;
    path.quality = 1.0;
    return path;
}

// Seed 1 at 2.5 mm. Created once.
inline const patient::Package& seededTruth() {
    static const patient::Package package = [] {
        patient::synth::SynthSettings s;
        s.seed = 1;
        s.spacing_m = 0.0025;
        s.defaults = tissueDefaults();
        return patient::synth::makeReferencePatient(s);
    }();
    return package;
}

// Moves all labels one voxel toward the feet and crops the CT, as a build does.
inline patient::Package movedAndCut(const patient::Package& truth) {
    patient::Package found = truth;
    const Grid& whole = truth.ct.grid;
    const Index3 corner{2, 1, 0};
    Grid part = whole;
    part.dims -= corner + 1;
    part.origin_m = whole.centre(corner);
    found.ct = CtVolume(part);
    found.labels = LabelVolume(part);
    forEachVoxel(part, [&](const Index3& i) {
        found.ct[i] = std::max(truth.ct[i + corner], std::int16_t(-1024));
        if (found.ct[i] < -600) found.ct[i] = -1024;
        found.labels[i] = truth.labels[i + corner + Index3(0, 0, 1)];
    });
    markAsBuilt(found);
    return found;
}

inline const study::Pair& seededPair() {
    static const study::Pair pair =
        study::makePair(kTestFiles, seededTruth(), movedAndCut(seededTruth()), study::FoundLabels::partial);
    return pair;
}

// A few hundred paths in the seeded patient.
inline const std::vector<patient::PlannedPath>& seededPaths() {
    static const std::vector<patient::PlannedPath> paths = [] {
        study::PlanRequest request;
        request.skin_spacing_m = 0.005;
        return study::planPair(seededPair(), request).result.paths;
    }();
    return paths;
}

}  // namespace stylet::test
