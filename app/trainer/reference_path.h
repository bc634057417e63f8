// The path that an attempt is led along and scored against.
#pragma once

#include <filesystem>
#include <string>

#include "app/trainer/start.h"
#include "patient/planning.h"

namespace stylet::trainer {

// In the breath of a commanded hold, end-exhale. `asked`: empty, the best of the patient's; a number N, his
// N-th best; else the folder of an attempt on him: the straight way of its needle from the skin into the
// target duct. Throws patient::DataError: there are fewer, it is another patient's, it did not hit. A plan is
// counted in `made`.
patient::PlannedPath referencePath(const patient::Patient&, const std::filesystem::path& patient_folder,
                                   const std::string& asked, Made* made = nullptr);

}  // namespace stylet::trainer
