// Every function that the mock runtime may offer, with the results that the specification lists for it
// (registry of OpenXR 1.0.33, `successcodes` and `errorcodes`). XR_ERROR_RUNTIME_FAILURE is omitted on
// purpose: no arguments may make this runtime fail.
#pragma once

#include "tests/xr/mock/client/client.h"

namespace mock_test {

// The results that most functions share, by the object that they act on.
enum class Family { destroy, instance, session };

bool isListed(XrResult result, Family family, std::initializer_list<XrResult> more);

// _(function, family, further results...)
#define MOCK_TEST_EVERY_FUNCTION(_)                                                                          \
    _(GetInstanceProperties, instance)                                                                       \
    _(PollEvent, instance, XR_EVENT_UNAVAILABLE)                                                             \
    _(ResultToString, instance)                                                                              \
    _(StructureTypeToString, instance)                                                                       \
    _(StringToPath, instance, XR_ERROR_PATH_FORMAT_INVALID, XR_ERROR_PATH_COUNT_EXCEEDED)                    \
    _(PathToString, instance, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_PATH_INVALID)                             \
    _(GetSystem, instance, XR_ERROR_FORM_FACTOR_UNSUPPORTED, XR_ERROR_FORM_FACTOR_UNAVAILABLE)               \
    _(GetSystemProperties, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_SYSTEM_INVALID)                        \
    _(EnumerateEnvironmentBlendModes, instance, XR_ERROR_SIZE_INSUFFICIENT,                                  \
      XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, XR_ERROR_SYSTEM_INVALID)                                 \
    _(EnumerateViewConfigurations, instance, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_SYSTEM_INVALID)            \
    _(GetViewConfigurationProperties, instance, XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,                \
      XR_ERROR_SYSTEM_INVALID)                                                                               \
    _(EnumerateViewConfigurationViews, instance, XR_ERROR_SIZE_INSUFFICIENT,                                 \
      XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, XR_ERROR_SYSTEM_INVALID)                                 \
    _(CreateSession, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED, XR_ERROR_SYSTEM_INVALID,      \
      XR_ERROR_INITIALIZATION_FAILED, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING,                           \
      XR_ERROR_GRAPHICS_DEVICE_INVALID)                                                                      \
    _(DestroySession, destroy)                                                                               \
    _(BeginSession, session, XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED, XR_ERROR_SESSION_RUNNING,         \
      XR_ERROR_SESSION_NOT_READY)                                                                            \
    _(EndSession, session, XR_ERROR_SESSION_NOT_STOPPING, XR_ERROR_SESSION_NOT_RUNNING)                      \
    _(RequestExitSession, session, XR_ERROR_SESSION_NOT_RUNNING)                                             \
    _(EnumerateReferenceSpaces, session, XR_ERROR_SIZE_INSUFFICIENT)                                         \
    _(CreateReferenceSpace, session, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED,                         \
      XR_ERROR_REFERENCE_SPACE_UNSUPPORTED, XR_ERROR_POSE_INVALID)                                           \
    _(GetReferenceSpaceBoundsRect, session, XR_SPACE_BOUNDS_UNAVAILABLE,                                     \
      XR_ERROR_REFERENCE_SPACE_UNSUPPORTED)                                                                  \
    _(CreateActionSpace, session, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED, XR_ERROR_POSE_INVALID,     \
      XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID, XR_ERROR_ACTION_TYPE_MISMATCH)                       \
    _(LocateSpace, session, XR_ERROR_TIME_INVALID)                                                           \
    _(DestroySpace, destroy)                                                                                 \
    _(LocateViews, session, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,        \
      XR_ERROR_TIME_INVALID)                                                                                 \
    _(EnumerateSwapchainFormats, session, XR_ERROR_SIZE_INSUFFICIENT)                                        \
    _(CreateSwapchain, session, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED,                              \
      XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, XR_ERROR_FEATURE_UNSUPPORTED)                                   \
    _(DestroySwapchain, destroy)                                                                             \
    _(EnumerateSwapchainImages, session, XR_ERROR_SIZE_INSUFFICIENT)                                         \
    _(AcquireSwapchainImage, session, XR_ERROR_CALL_ORDER_INVALID)                                           \
    _(WaitSwapchainImage, session, XR_TIMEOUT_EXPIRED, XR_ERROR_CALL_ORDER_INVALID)                          \
    _(ReleaseSwapchainImage, session, XR_ERROR_CALL_ORDER_INVALID)                                           \
    _(WaitFrame, session, XR_ERROR_SESSION_NOT_RUNNING)                                                      \
    _(BeginFrame, session, XR_FRAME_DISCARDED, XR_ERROR_SESSION_NOT_RUNNING, XR_ERROR_CALL_ORDER_INVALID)    \
    _(EndFrame, session, XR_ERROR_TIME_INVALID, XR_ERROR_SWAPCHAIN_RECT_INVALID,                             \
      XR_ERROR_SESSION_NOT_RUNNING, XR_ERROR_POSE_INVALID, XR_ERROR_LAYER_LIMIT_EXCEEDED,                    \
      XR_ERROR_LAYER_INVALID, XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, XR_ERROR_CALL_ORDER_INVALID)      \
    _(CreateActionSet, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED,                             \
      XR_ERROR_PATH_FORMAT_INVALID, XR_ERROR_NAME_INVALID, XR_ERROR_NAME_DUPLICATED,                         \
      XR_ERROR_LOCALIZED_NAME_INVALID, XR_ERROR_LOCALIZED_NAME_DUPLICATED)                                   \
    _(DestroyActionSet, destroy)                                                                             \
    _(CreateAction, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED, XR_ERROR_PATH_UNSUPPORTED,     \
      XR_ERROR_PATH_INVALID, XR_ERROR_PATH_FORMAT_INVALID, XR_ERROR_NAME_INVALID, XR_ERROR_NAME_DUPLICATED,  \
      XR_ERROR_LOCALIZED_NAME_INVALID, XR_ERROR_LOCALIZED_NAME_DUPLICATED,                                   \
      XR_ERROR_ACTIONSETS_ALREADY_ATTACHED)                                                                  \
    _(DestroyAction, destroy)                                                                                \
    _(SuggestInteractionProfileBindings, instance, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,         \
      XR_ERROR_ACTIONSETS_ALREADY_ATTACHED)                                                                  \
    _(AttachSessionActionSets, session, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED)                                \
    _(GetCurrentInteractionProfile, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,               \
      XR_ERROR_ACTIONSET_NOT_ATTACHED)                                                                       \
    _(GetActionStateBoolean, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,                      \
      XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED)                                        \
    _(GetActionStateFloat, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,                        \
      XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED)                                        \
    _(GetActionStateVector2f, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,                     \
      XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED)                                        \
    _(GetActionStatePose, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,                         \
      XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED)                                        \
    _(SyncActions, session, XR_SESSION_NOT_FOCUSED, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID,        \
      XR_ERROR_ACTIONSET_NOT_ATTACHED)                                                                       \
    _(EnumerateBoundSourcesForAction, session, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_PATH_INVALID,            \
      XR_ERROR_ACTIONSET_NOT_ATTACHED)                                                                       \
    _(GetInputSourceLocalizedName, session, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_PATH_UNSUPPORTED,           \
      XR_ERROR_PATH_INVALID, XR_ERROR_ACTIONSET_NOT_ATTACHED)                                                \
    _(ApplyHapticFeedback, session, XR_SESSION_NOT_FOCUSED, XR_ERROR_PATH_UNSUPPORTED,                       \
      XR_ERROR_PATH_INVALID, XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED)                 \
    _(StopHapticFeedback, session, XR_SESSION_NOT_FOCUSED, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID, \
      XR_ERROR_ACTION_TYPE_MISMATCH, XR_ERROR_ACTIONSET_NOT_ATTACHED)                                        \
    _(GetVulkanInstanceExtensionsKHR, instance, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_SYSTEM_INVALID)         \
    _(GetVulkanDeviceExtensionsKHR, instance, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_SYSTEM_INVALID)           \
    _(GetVulkanGraphicsDeviceKHR, instance, XR_ERROR_SYSTEM_INVALID)                                         \
    _(GetVulkanGraphicsRequirementsKHR, instance, XR_ERROR_SYSTEM_INVALID)                                   \
    _(CreateVulkanInstanceKHR, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED,                     \
      XR_ERROR_SYSTEM_INVALID)                                                                               \
    _(CreateVulkanDeviceKHR, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED,                       \
      XR_ERROR_SYSTEM_INVALID)                                                                               \
    _(GetVulkanGraphicsDevice2KHR, instance, XR_ERROR_SYSTEM_INVALID)                                        \
    _(GetVulkanGraphicsRequirements2KHR, instance, XR_ERROR_SYSTEM_INVALID)                                  \
    _(GetVisibilityMaskKHR, session, XR_ERROR_SIZE_INSUFFICIENT,                                             \
      XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED)                                                          \
    _(ConvertTimespecTimeToTimeKHR, instance, XR_ERROR_TIME_INVALID)                                         \
    _(ConvertTimeToTimespecTimeKHR, instance, XR_ERROR_TIME_INVALID)                                         \
    _(SetDebugUtilsObjectNameEXT, instance, XR_ERROR_OUT_OF_MEMORY)                                          \
    _(CreateDebugUtilsMessengerEXT, instance, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED)                \
    _(DestroyDebugUtilsMessengerEXT, destroy)                                                                \
    _(SubmitDebugUtilsMessageEXT, instance)                                                                  \
    _(SessionBeginDebugUtilsLabelRegionEXT, session)                                                         \
    _(SessionEndDebugUtilsLabelRegionEXT, session)                                                           \
    _(SessionInsertDebugUtilsLabelEXT, session)                                                              \
    _(SetInputDeviceActiveEXT, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID)                    \
    _(SetInputDeviceStateBoolEXT, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID)                 \
    _(SetInputDeviceStateFloatEXT, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID)                \
    _(SetInputDeviceStateVector2fEXT, session, XR_ERROR_PATH_UNSUPPORTED, XR_ERROR_PATH_INVALID)             \
    _(SetInputDeviceLocationEXT, session, XR_ERROR_POSE_INVALID, XR_ERROR_PATH_UNSUPPORTED,                  \
      XR_ERROR_PATH_INVALID)                                                                                 \
    _(CreateHandTrackerEXT, session, XR_ERROR_OUT_OF_MEMORY, XR_ERROR_LIMIT_REACHED,                         \
      XR_ERROR_FEATURE_UNSUPPORTED)                                                                          \
    _(DestroyHandTrackerEXT, destroy)                                                                        \
    _(LocateHandJointsEXT, session, XR_ERROR_TIME_INVALID)                                                   \
    _(EnumerateDisplayRefreshRatesFB, session, XR_ERROR_SIZE_INSUFFICIENT)                                   \
    _(GetDisplayRefreshRateFB, session)                                                                      \
    _(RequestDisplayRefreshRateFB, session, XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB,                    \
      XR_ERROR_FEATURE_UNSUPPORTED)

}  // namespace mock_test
