#include "names.h"

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

std::string structureTypeName(XrStructureType type) {
    switch (type) { XR_LIST_ENUM_XrStructureType(XRMOCK_CASE) default : break; }
    return "XR_UNKNOWN_STRUCTURE_TYPE_" + std::to_string(static_cast<int>(type));
}

#undef XRMOCK_CASE

}  // namespace xrmock
