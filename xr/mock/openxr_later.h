// Declarations that the OpenXR headers of some distributions lack, from the specification. One section per
// extension; each gives way to a header that has it. A section whose structures are new lists their names for
// xrStructureTypeToString.
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
