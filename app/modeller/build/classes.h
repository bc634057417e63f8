// classes.json of a build: what the values of this CT mean, for whoever reviews it, and the thresholds that
// follow, which a person may edit.
#pragma once

#include <string>

#include "app/modeller/tissue_classes.h"

namespace stylet::modeller {

std::string writeClasses(const TissueClasses&, const patient::Thresholds&);

// Throws ImportError where a threshold is missing or absurd, or they do not rise.
patient::Thresholds parseClasses(const std::string& text);

}  // namespace stylet::modeller
