// The reference patient: a torso section generated from a seed. The same seed gives the same bytes on
// every machine.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"

namespace stylet::patient::synth {

struct SynthSettings {
    std::uint64_t seed = 1;
    double spacing_m = 0.001;           // isotropic; tests use 0.002 and more
    std::vector<std::string> variants;  // names from listVariants(); none: the reference patient
    TissueDefaults defaults;            // initial force table and thresholds
    bool motion = true;                 // false saves time; the package then cannot breathe
    int threads = 2;                    // does not affect the result
    std::function<void(std::string_view stage, double fraction)> progress;
};

// Labels of the reference patient, in the order of their ids (1, 2, ...).
const std::vector<Label>& labelTable();

// Throws std::invalid_argument for an unknown variant, and for two variants that exclude each other.
Package makeReferencePatient(const SynthSettings&);

// A hard case that can be made of any seed: another scan, body or disease. Used to tune and to report the
// modeller on patients unlike its atlases.
struct VariantInfo {
    std::string name, changes, source;
};
std::vector<VariantInfo> listVariants();

// One line of `stylet-model check`: a measured value and its allowed range.
struct CheckLine {
    std::string name, unit;
    double value = 0.0, low = 0.0, high = 0.0;
    bool ok() const { return value >= low && value <= high; }
};
// True if the package has the reference patient's label table and is not a variant.
bool isReferencePatient(const Package&);
// Measures the voxels of a reference patient. Throws std::invalid_argument for another package.
std::vector<CheckLine> checkPatient(const Package&);

}  // namespace stylet::patient::synth
