// Names of result codes, structure types and functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "openxr_api.h"

namespace xrmock {

std::string resultName(XrResult result);
std::optional<XrResult> resultNamed(std::string_view name);
std::string structureTypeName(XrStructureType type);
std::string sessionStateName(XrSessionState state);  // "focused"
std::optional<XrSessionState> sessionStateNamed(std::string_view name);
// Whether the runtime offers a function of this name, with whatever extension.
bool isFunctionName(std::string_view name);

}  // namespace xrmock
