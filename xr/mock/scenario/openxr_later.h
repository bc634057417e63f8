// Declarations from the OpenXR specification that the headers of some distributions lack. There is one
// section per extension. A section is skipped if the header already has the extension. Sections with new
// structures list their names for xrStructureTypeToString.
#pragma once

#include <openxr/openxr.h>

#ifndef XR_EXT_local_floor
#define XR_EXT_local_floor 1
#define XR_EXT_local_floor_SPEC_VERSION 1
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
constexpr auto XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT = static_cast<XrReferenceSpaceType>(1000426000);
#endif

#ifndef XR_EXT_user_presence
#define XR_EXT_user_presence 1
#define XR_EXT_user_presence_SPEC_VERSION 1
#define XR_EXT_USER_PRESENCE_EXTENSION_NAME "XR_EXT_user_presence"
constexpr auto XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT = static_cast<XrStructureType>(1000470000);
constexpr auto XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT = static_cast<XrStructureType>(1000470001);
struct XrEventDataUserPresenceChangedEXT {
    XrStructureType type;
    const void* next;
    XrSession session;
    XrBool32 isUserPresent;
};
struct XrSystemUserPresencePropertiesEXT {
    XrStructureType type;
    void* next;
    XrBool32 supportsUserPresence;
};
#define XRMOCK_LATER_STRUCTURES_USER_PRESENCE(_)    \
    _(XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT) \
    _(XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT)
#else
#define XRMOCK_LATER_STRUCTURES_USER_PRESENCE(_)
#endif

#ifndef XR_EXT_uuid
#define XR_EXT_uuid 1
#define XR_EXT_uuid_SPEC_VERSION 1
#define XR_EXT_UUID_EXTENSION_NAME "XR_EXT_uuid"
struct XrUuidEXT {
    uint8_t data[16];
};
#endif

#ifndef XR_EXT_stationary_reference_space
#define XR_EXT_stationary_reference_space 1
#define XR_EXT_stationary_reference_space_SPEC_VERSION 1
#define XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME "XR_EXT_stationary_reference_space"
constexpr auto XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT = static_cast<XrReferenceSpaceType>(1000742000);
constexpr auto XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_GET_INFO_EXT =
    static_cast<XrStructureType>(1000742001);
constexpr auto XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_RESULT_EXT =
    static_cast<XrStructureType>(1000742002);
struct XrStationaryReferenceSpaceGenerationIdGetInfoEXT {
    XrStructureType type;
    const void* next;
};
struct XrStationaryReferenceSpaceGenerationIdResultEXT {
    XrStructureType type;
    void* next;
    XrUuidEXT generationId;
};
#define XRMOCK_LATER_STRUCTURES_STATIONARY(_)                        \
    _(XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_GET_INFO_EXT) \
    _(XR_TYPE_STATIONARY_REFERENCE_SPACE_GENERATION_ID_RESULT_EXT)
#else
#define XRMOCK_LATER_STRUCTURES_STATIONARY(_)
#endif

#ifndef XR_BD_controller_interaction
#define XR_BD_controller_interaction 1
#define XR_BD_controller_interaction_SPEC_VERSION 2
#define XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME "XR_BD_controller_interaction"
#endif

#ifndef XR_FB_touch_controller_pro
#define XR_FB_touch_controller_pro 1
#define XR_FB_touch_controller_pro_SPEC_VERSION 1
#define XR_FB_TOUCH_CONTROLLER_PRO_EXTENSION_NAME "XR_FB_touch_controller_pro"
#endif

#ifndef XR_META_touch_controller_plus
#define XR_META_touch_controller_plus 1
#define XR_META_touch_controller_plus_SPEC_VERSION 1
#define XR_META_TOUCH_CONTROLLER_PLUS_EXTENSION_NAME "XR_META_touch_controller_plus"
#endif

#ifndef XR_EXT_palm_pose
#define XR_EXT_palm_pose 1
#define XR_EXT_palm_pose_SPEC_VERSION 3
#define XR_EXT_PALM_POSE_EXTENSION_NAME "XR_EXT_palm_pose"
#endif

#ifndef XR_HTC_vive_focus3_controller_interaction
#define XR_HTC_vive_focus3_controller_interaction 1
#define XR_HTC_vive_focus3_controller_interaction_SPEC_VERSION 2
#define XR_HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME "XR_HTC_vive_focus3_controller_interaction"
#endif

#ifndef XR_EXT_active_action_set_priority
#define XR_EXT_active_action_set_priority 1
#define XR_EXT_active_action_set_priority_SPEC_VERSION 1
#define XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME "XR_EXT_active_action_set_priority"
constexpr auto XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT = static_cast<XrStructureType>(1000373000);
struct XrActiveActionSetPriorityEXT {
    XrActionSet actionSet;
    uint32_t priorityOverride;
};
struct XrActiveActionSetPrioritiesEXT {
    XrStructureType type;
    const void* next;
    uint32_t actionSetPriorityCount;
    const XrActiveActionSetPriorityEXT* actionSetPriorities;
};
#define XRMOCK_LATER_STRUCTURES_ACTION_SET_PRIORITY(_) _(XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT)
#else
#define XRMOCK_LATER_STRUCTURES_ACTION_SET_PRIORITY(_)
#endif
