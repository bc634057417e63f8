// Names of result codes, structure types and functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "scenario/openxr_api.h"

namespace xrmock {

std::string resultName(XrResult result);
std::optional<XrResult> resultNamed(std::string_view name);
std::string structureTypeName(XrStructureType type);
std::string sessionStateName(XrSessionState state);  // "focused"
std::optional<XrSessionState> sessionStateNamed(std::string_view name);
// Returns whether a scenario may refuse the function: the runtime implements it, possibly in an extension,
// and it needs an instance.
bool isRefusable(std::string_view name);

}  // namespace xrmock
