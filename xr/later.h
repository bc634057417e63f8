// Declarations from the OpenXR specification that Debian's header (1.0.20) lacks. Each is skipped if the
// header already has it.
#pragma once

#include <openxr/openxr.h>

#ifndef XR_EXT_local_floor
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
inline constexpr auto XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT = XrReferenceSpaceType(1000426000);
#endif

#ifndef XR_EXT_user_presence
#define XR_EXT_USER_PRESENCE_EXTENSION_NAME "XR_EXT_user_presence"
inline constexpr auto XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT = XrStructureType(1000470000);
struct XrEventDataUserPresenceChangedEXT {
    XrStructureType type;
    const void* next;
    XrSession session;
    XrBool32 isUserPresent;
};
#endif

#ifndef XR_EXT_uuid
#define XR_EXT_UUID_EXTENSION_NAME "XR_EXT_uuid"
struct XrUuidEXT {
    std::uint8_t data[16];
};
#endif

#ifndef XR_EXT_stationary_reference_space
#define XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME "XR_EXT_stationary_reference_space"
inline constexpr auto XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT = XrReferenceSpaceType(1000742000);
inline constexpr auto XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_GET_INFO_EXT =
    XrStructureType(1000742001);
inline constexpr auto XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_RESULT_EXT =
    XrStructureType(1000742002);
struct XrStationaryReferenceSpaceGenerationIdGetInfoEXT {
    XrStructureType type;
    const void* next;
};
struct XrStationaryReferenceSpaceGenerationIdResultEXT {
    XrStructureType type;
    void* next;
    XrUuidEXT generationId;
};
using PFN_xrGetStationaryReferenceSpaceGenerationIdEXT =
    XrResult(XRAPI_PTR*)(XrSession, const XrStationaryReferenceSpaceGenerationIdGetInfoEXT*,
                         XrStationaryReferenceSpaceGenerationIdResultEXT*);
#endif

#ifndef XR_HTC_vive_focus3_controller_interaction
#define XR_HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME "XR_HTC_vive_focus3_controller_interaction"
#endif
#ifndef XR_BD_controller_interaction
#define XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME "XR_BD_controller_interaction"
#endif
#ifndef XR_FB_touch_controller_pro
#define XR_FB_TOUCH_CONTROLLER_PRO_EXTENSION_NAME "XR_FB_touch_controller_pro"
#endif
#ifndef XR_META_touch_controller_plus
#define XR_META_TOUCH_CONTROLLER_PLUS_EXTENSION_NAME "XR_META_touch_controller_plus"
#endif
