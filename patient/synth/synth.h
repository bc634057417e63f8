// The reference patient: a torso section made from a seed. Same seed, same bytes, on every machine.
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
    double spacing_m = 0.001;  // isotropic; tests use 0.002 and more
    TissueDefaults defaults;   // force table and thresholds to start from
    int threads = 2;           // does not change the result
    std::function<void(std::string_view stage, double fraction)> progress;
};

// Labels of the reference patient, in the order of their ids (1, 2, ...).
const std::vector<Label>& labelTable();

Package makeReferencePatient(const SynthSettings&);

// One line of `stylet-model check`: a measured value against its range.
struct CheckLine {
    std::string name, unit;
    double value = 0.0, low = 0.0, high = 0.0;
    bool ok() const { return value >= low && value <= high; }
};
// Whether it has the reference patient's label table.
bool isReferencePatient(const Package&);
// Measures the voxels of a reference patient, not what its maker meant. Another package:
// std::invalid_argument.
std::vector<CheckLine> checkPatient(const Package&);

}  // namespace stylet::patient::synth
