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
};

struct OpenedPatient {
    std::filesystem::path folder;
    patient::Package package;
    Made made{};
};

// Throws DataError. Reports slow steps on stderr.
OpenedPatient openPatient(const PatientRequest&);

// Loads a package from a cache folder that other programs may read, check or rebuild at the same time.
// Returns nothing if there is no package, or if it was damaged; a damaged package is deleted. Throws
// DataError if files cannot be opened, which does not count as damage.
using LoadPackage = std::function<patient::Package(const std::filesystem::path&)>;
std::optional<patient::Package> keptPackage(const std::filesystem::path& folder,
                                            const LoadPackage& load = patient::loadPackage);

// Paths planned for `breath`, best first, never empty. They come from the patient's paths.json if the file
// is intact and matches this patient (by digest), the planner version and the breath. Otherwise they are
// planned, and stored there if the folder is writable. Throws DataError if no path is good enough.
// `made` counts a plan.
std::vector<patient::PlannedPath> goodPaths(const patient::Patient&, const std::filesystem::path& folder,
                                            const patient::Surrogate& breath, Made* made = nullptr);
// The first path of goodPaths().
patient::PlannedPath bestPath(const patient::Patient&, const std::filesystem::path& folder,
                              const patient::Surrogate& breath);

}  // namespace stylet::trainer
