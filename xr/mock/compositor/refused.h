// The error of a call that the runtime refuses.
#pragma once

#include <string>
#include <utility>

#include "scenario/openxr_api.h"

namespace xrmock {

// Ends a call with an error code. The reason is sent to the application's debug messengers.
struct Refused {
    XrResult result;
    std::string reason;
};
[[noreturn]] inline void refuse(XrResult result, std::string reason) {
    throw Refused{result, std::move(reason)};
}
inline void require(bool fulfilled, XrResult otherwise, const char* reason) {
    if (!fulfilled) refuse(otherwise, reason);
}
inline void requireValid(bool fulfilled, const char* reason) {
    require(fulfilled, XR_ERROR_VALIDATION_FAILURE, reason);
}

}  // namespace xrmock
