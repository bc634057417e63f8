// Where the patient on the table comes from, and the path into him.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "app/trainer/start.h"
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
    Made made{};
};

// Throws patient::DataError. Says on stderr what takes long.
OpenedPatient openPatient(const PatientRequest&);

// The package in a folder of the cache, which other programs read, judge and make anew at the same time.
// Nothing: there is none, or it was damaged and is gone. Throws patient::DataError where it cannot be opened,
// which is no damage.
using LoadPackage = std::function<patient::Package(const std::filesystem::path&)>;
std::optional<patient::Package> keptPackage(const std::filesystem::path& folder,
                                            const LoadPackage& load = patient::loadPackage);

// The paths for `breath`, best first, never none: from the patient's paths.json if it is whole, of this very
// patient (by digest), planner and breath; else planned, and kept there where the folder can be written.
// Throws patient::DataError when no path is good enough. A plan is counted in `made`.
std::vector<patient::PlannedPath> goodPaths(const patient::Patient&, const std::filesystem::path& folder,
                                            const patient::Surrogate& breath, Made* made = nullptr);
// The first of them.
patient::PlannedPath bestPath(const patient::Patient&, const std::filesystem::path& folder,
                              const patient::Surrogate& breath);

}  // namespace stylet::trainer
