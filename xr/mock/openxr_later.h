// Declarations that the OpenXR headers of some distributions lack, from the specification. One section per
// extension; each gives way to a header that has it. A section whose structures are new lists their names for
// xrStructureTypeToString.
#pragma once

#include "openxr_api.h"

#ifndef XR_EXT_local_floor
#define XR_EXT_local_floor 1
#define XR_EXT_local_floor_SPEC_VERSION 1
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
constexpr auto XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT = static_cast<XrReferenceSpaceType>(1000426000);
#endif
