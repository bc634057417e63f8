// A built package against the truth, structure by structure.
#pragma once

#include <string>
#include <vector>

#include "app/modeller/build/accuracy.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct Judged {
    std::string structure;
    Agreement agreement;  // `there`: within 5 mm of a planned path, what a needle and its deviations meet
};

// Those that the truth has, on the found package's grid. Liver means what a surgeon means: with tumours,
// cysts, vessels and ducts.
std::vector<Judged> judge(const patient::Package& truth, const patient::Package& found,
                          const std::vector<patient::PlannedPath>& paths);

}  // namespace stylet::modeller
