// Compares a built package with the truth, structure by structure.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/modeller/segmentation/accuracy.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct StructureAgreement {
    std::string structure;
    Agreement agreement;  // `mean_surface_near_m`: within 5 mm of a planned path
};

// Compares the structures that exist in the truth, on the truth's voxels at the heights of the found
// package and of the whole liver. The liver includes tumours, cysts, vessels and ducts.
std::vector<StructureAgreement> compareStructures(const patient::Package& truth,
                                                  const patient::Package& found,
                                                  const std::vector<patient::PlannedPath>& paths);

// The names of the true risk structures that paths cross, and the number of paths. A path that crosses
// several is counted for the first. The paths were planned in another package of the same CT, in its
// breathing state.
std::map<std::string, std::size_t> countRiskCrossings(const patient::Package& truth,
                                                      const std::vector<patient::PlannedPath>& paths);

}  // namespace stylet::modeller
