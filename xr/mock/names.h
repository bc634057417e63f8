// Names of result codes and structure types.
#pragma once

#include <string>

#include "openxr_api.h"

namespace xrmock {

std::string resultName(XrResult result);
std::string structureTypeName(XrStructureType type);

}  // namespace xrmock
