#include "xr/check.h"

#include <fmt/core.h>
#include <openxr/openxr_reflection.h>

namespace stylet::xr {

std::string resultName(XrResult result) {
    switch (result) {
#define STYLET_RESULT_CASE(name, value) \
    case name:                          \
        return #name;
        XR_LIST_ENUM_XrResult(STYLET_RESULT_CASE)
#undef STYLET_RESULT_CASE
                default : return "XrResult " +
                          std::to_string(int(result));
    }
}

void fail(XrResult result, const char* call, std::string_view meaning) {
    throw XrError(fmt::format("{}: {}: {}", call, resultName(result), meaning));
}

}  // namespace stylet::xr
