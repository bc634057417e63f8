// Compares a built package with the truth, structure by structure.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/segmentation/accuracy.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct Judged {
    std::string structure;
    Agreement agreement;  // `there`: within 5 mm of a planned path
};

// Compares the structures that exist in the truth, on the truth's voxels at the heights of the found
// package and of the whole liver. The liver includes tumours, cysts, vessels and ducts.
std::vector<Judged> judge(const patient::Package& truth, const patient::Package& found,
                          const std::vector<patient::PlannedPath>& paths);

}  // namespace stylet::modeller
