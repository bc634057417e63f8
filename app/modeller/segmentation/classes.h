// classes.json of a build: the tissue classes of this CT, for review, and the thresholds derived from them,
// which a person may edit.
#pragma once

#include <string>

#include "app/modeller/import/tissue_classes.h"

namespace stylet::modeller {

std::string writeClasses(const TissueClasses&, const patient::Thresholds&);

// Throws DataError if a threshold is missing or out of range, or if the thresholds are not increasing.
patient::Thresholds parseClasses(const std::string& text);

}  // namespace stylet::modeller
