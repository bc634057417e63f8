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
// Whether a scenario may refuse the function: the runtime offers it, with whatever extension, and it is about
// an instance or what belongs to one.
bool isRefusable(std::string_view name);

}  // namespace xrmock
