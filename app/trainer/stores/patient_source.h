// Loads or generates the patient, and loads or plans the needle paths.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "app/trainer/stores/start.h"
#include "patient/patient.h"

namespace stylet::trainer {

struct PatientRequest {
    std::filesystem::path folder;  // empty: the reference patient of `seed`, generated once into `cache`
    std::uint64_t seed = 1;
    double spacing_m = 0.001;  // voxel size of a reference patient
    std::filesystem::path cache;
    std::filesystem::path assets;
    bool accept_implausible = false;  // open a package that `stylet-model check` refused
};

// The same choice as command-line options.
struct PatientOptions {
    std::filesystem::path folder{};  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;  // voxel size of a reference patient
};

struct OpenedPatient {
    std::filesystem::path folder;
    patient::Package package;
    Made made{};
    // What the attempt's record says about the check of the package; empty: accepted, or a reference patient.
    std::string check{};
};

// Throws DataError. Reports slow steps on stderr.
OpenedPatient openPatient(const PatientRequest&);
// Uses the cache of the user and the assets of the installation.
OpenedPatient openPatient(const PatientOptions&);

// Loads a package from a cache folder that other programs may read, check or rebuild at the same time.
// Returns nothing if there is no package, or if it was damaged; a damaged package is deleted. Throws
// DataError if files cannot be opened, which does not count as damage.
using LoadPackage = std::function<patient::Package(const std::filesystem::path&)>;
std::optional<patient::Package> loadCachedPackage(const std::filesystem::path& folder,
                                                  const LoadPackage& load = patient::loadPackage);

// Returns the paths planned for `breath`, best first, never empty. They are read from the patient's
// paths.json if that file is intact and matches this patient (by digest), the planner version and the breath.
// Otherwise they are planned and, if the folder is writable, stored there. Throws DataError if no path is
// good enough. `made` counts newly computed plans.
std::vector<patient::PlannedPath> goodPaths(const patient::Patient&, const std::filesystem::path& folder,
                                            const patient::Surrogate& breath, Made* made = nullptr);
// The first path of goodPaths().
patient::PlannedPath bestPath(const patient::Patient&, const std::filesystem::path& folder,
                              const patient::Surrogate& breath);

}  // namespace stylet::trainer
