#include "scenario/names.h"

#include <openxr/openxr_reflection.h>

namespace xrmock {

#define XRMOCK_CASE(name, value) \
    case name:                   \
        return #name;

std::string resultName(XrResult result) {
    switch (result) { XR_LIST_ENUM_XrResult(XRMOCK_CASE) default : break; }
    return (result < 0 ? "XR_UNKNOWN_FAILURE_" : "XR_UNKNOWN_SUCCESS_") +
           std::to_string(static_cast<int>(result));
}

std::optional<XrResult> resultNamed(std::string_view name) {
#define XRMOCK_COMPARE(each, value) \
    if (name == #each) return each;
    XR_LIST_ENUM_XrResult(XRMOCK_COMPARE)
#undef XRMOCK_COMPARE
        return std::nullopt;
}

std::string structureTypeName(XrStructureType type) {
    switch (type) { XR_LIST_ENUM_XrStructureType(XRMOCK_CASE) default : break; }
#define XRMOCK_COMPARE(each) \
    if (type == each) return #each;
    XRMOCK_LATER_STRUCTURES_USER_PRESENCE(XRMOCK_COMPARE)
    XRMOCK_LATER_STRUCTURES_ACTION_SET_PRIORITY(XRMOCK_COMPARE)
    XRMOCK_LATER_STRUCTURES_STATIONARY(XRMOCK_COMPARE)
#undef XRMOCK_COMPARE
    return "XR_UNKNOWN_STRUCTURE_TYPE_" + std::to_string(static_cast<int>(type));
}

#undef XRMOCK_CASE

namespace {
constexpr std::string_view kStateNames[] = {"unknown", "idle",     "ready",        "synchronized", "visible",
                                            "focused", "stopping", "loss_pending", "exiting"};
}

std::string sessionStateName(XrSessionState state) {
    return std::string(kStateNames[static_cast<std::size_t>(state)]);
}

std::optional<XrSessionState> sessionStateNamed(std::string_view name) {
    for (std::size_t i = 0; i < std::size(kStateNames); ++i)
        if (kStateNames[i] == name) return static_cast<XrSessionState>(i);
    return std::nullopt;
}

}  // namespace xrmock
