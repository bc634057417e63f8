// Where the patient on the table comes from, and the path into him.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "patient/patient.h"

namespace stylet::trainer {

struct PatientRequest {
    std::filesystem::path folder;  // empty: the reference patient of `seed`, made once into `cache`
    std::uint64_t seed = 1;
    double spacing_m = 0.001;  // of a reference patient
    std::filesystem::path cache;
    std::filesystem::path assets;
};

struct OpenedPatient {
    std::filesystem::path folder;
    patient::Package package;
};

// Throws patient::DataError. Says on stderr what takes long.
OpenedPatient openPatient(const PatientRequest&);

// The paths for `breath`, best first, never none: from the patient's paths.json if it is whole, of this very
// patient (by digest), planner and breath; else planned, and kept there where the folder can be written.
// Throws patient::DataError when no path is good enough.
std::vector<patient::PlannedPath> goodPaths(const patient::Patient&, const std::filesystem::path& folder,
                                            const patient::Surrogate& breath);
// The first of them.
patient::PlannedPath bestPath(const patient::Patient&, const std::filesystem::path& folder,
                              const patient::Surrogate& breath);

}  // namespace stylet::trainer
