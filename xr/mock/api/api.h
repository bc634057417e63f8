// The OpenXR functions. Each validates all arguments and handles and returns the specified result. Other
// files do the work and trust their input. All functions run under the lock of their Call.
#pragma once

#include "scenario/openxr_later.h"
#include "world/call.h"

namespace xrmock {

constexpr XrVersion kApiVersion = XR_MAKE_VERSION(1, 0, 20);

// C entry point for loaders.
XRAPI_ATTR XrResult XRAPI_CALL getInstanceProcAddr(XrInstance instance, const char* name,
                                                   PFN_xrVoidFunction* function) noexcept;

struct ExtensionEntry {
    const char* name;
    std::uint32_t version;
};
inline constexpr ExtensionEntry kExtensions[] = {
    {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, XR_KHR_vulkan_enable2_SPEC_VERSION},
    {XR_KHR_VULKAN_ENABLE_EXTENSION_NAME, XR_KHR_vulkan_enable_SPEC_VERSION},
    {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, XR_KHR_convert_timespec_time_SPEC_VERSION},
    {XR_KHR_COMPOSITION_LAYER_CYLINDER_EXTENSION_NAME, XR_KHR_composition_layer_cylinder_SPEC_VERSION},
    {XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME, XR_KHR_composition_layer_depth_SPEC_VERSION},
    {XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME, XR_EXT_active_action_set_priority_SPEC_VERSION},
    {XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, XR_EXT_conformance_automation_SPEC_VERSION},
    {XR_KHR_VISIBILITY_MASK_EXTENSION_NAME, XR_KHR_visibility_mask_SPEC_VERSION},
    {XR_EXT_DEBUG_UTILS_EXTENSION_NAME, XR_EXT_debug_utils_SPEC_VERSION},
    {XR_EXT_HAND_TRACKING_EXTENSION_NAME, XR_EXT_hand_tracking_SPEC_VERSION},
    {XR_EXT_HP_MIXED_REALITY_CONTROLLER_EXTENSION_NAME, XR_EXT_hp_mixed_reality_controller_SPEC_VERSION},
    {XR_EXT_LOCAL_FLOOR_EXTENSION_NAME, XR_EXT_local_floor_SPEC_VERSION},
    {XR_EXT_PALM_POSE_EXTENSION_NAME, XR_EXT_palm_pose_SPEC_VERSION},
    {XR_EXT_SAMSUNG_ODYSSEY_CONTROLLER_EXTENSION_NAME, XR_EXT_samsung_odyssey_controller_SPEC_VERSION},
    {XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME, XR_EXT_stationary_reference_space_SPEC_VERSION},
    {XR_EXT_USER_PRESENCE_EXTENSION_NAME, XR_EXT_user_presence_SPEC_VERSION},
    {XR_EXT_UUID_EXTENSION_NAME, XR_EXT_uuid_SPEC_VERSION},
    {XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME, XR_BD_controller_interaction_SPEC_VERSION},
    {XR_FB_TOUCH_CONTROLLER_PRO_EXTENSION_NAME, XR_FB_touch_controller_pro_SPEC_VERSION},
    {XR_META_TOUCH_CONTROLLER_PLUS_EXTENSION_NAME, XR_META_touch_controller_plus_SPEC_VERSION},
    {XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, XR_FB_display_refresh_rate_SPEC_VERSION},
    {XR_HTC_VIVE_COSMOS_CONTROLLER_INTERACTION_EXTENSION_NAME,
     XR_HTC_vive_cosmos_controller_interaction_SPEC_VERSION},
    {XR_HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME,
     XR_HTC_vive_focus3_controller_interaction_SPEC_VERSION},
};

// Instance and system
XrResult enumerateApiLayerProperties(Call&, std::uint32_t, std::uint32_t*, XrApiLayerProperties*);
XrResult enumerateInstanceExtensionProperties(Call&, const char*, std::uint32_t, std::uint32_t*,
                                              XrExtensionProperties*);
XrResult createInstance(Call&, const XrInstanceCreateInfo*, XrInstance*);
XrResult destroyInstance(Call&, XrInstance);
XrResult getInstanceProperties(Call&, XrInstance, XrInstanceProperties*);
XrResult pollEvent(Call&, XrInstance, XrEventDataBuffer*);
XrResult resultToString(Call&, XrInstance, XrResult, char*);
XrResult structureTypeToString(Call&, XrInstance, XrStructureType, char*);
XrResult stringToPath(Call&, XrInstance, const char*, XrPath*);
XrResult pathToString(Call&, XrInstance, XrPath, std::uint32_t, std::uint32_t*, char*);
XrResult getSystem(Call&, XrInstance, const XrSystemGetInfo*, XrSystemId*);
XrResult getSystemProperties(Call&, XrInstance, XrSystemId, XrSystemProperties*);
XrResult enumerateEnvironmentBlendModes(Call&, XrInstance, XrSystemId, XrViewConfigurationType, std::uint32_t,
                                        std::uint32_t*, XrEnvironmentBlendMode*);
XrResult enumerateViewConfigurations(Call&, XrInstance, XrSystemId, std::uint32_t, std::uint32_t*,
                                     XrViewConfigurationType*);
XrResult getViewConfigurationProperties(Call&, XrInstance, XrSystemId, XrViewConfigurationType,
                                        XrViewConfigurationProperties*);
XrResult enumerateViewConfigurationViews(Call&, XrInstance, XrSystemId, XrViewConfigurationType,
                                         std::uint32_t, std::uint32_t*, XrViewConfigurationView*);

// XR_KHR_vulkan_enable2 (getVulkanGraphicsRequirements also serves XR_KHR_vulkan_enable)
XrResult createVulkanInstance(Call&, XrInstance, const XrVulkanInstanceCreateInfoKHR*, VkInstance*,
                              VkResult*);
XrResult createVulkanDevice(Call&, XrInstance, const XrVulkanDeviceCreateInfoKHR*, VkDevice*, VkResult*);
XrResult getVulkanGraphicsDevice2(Call&, XrInstance, const XrVulkanGraphicsDeviceGetInfoKHR*,
                                  VkPhysicalDevice*);
XrResult getVulkanGraphicsRequirements(Call&, XrInstance, XrSystemId, XrGraphicsRequirementsVulkanKHR*);

// XR_KHR_vulkan_enable
// getVulkanExtensions serves both xrGetVulkan...ExtensionsKHR: the runtime requires no Vulkan extensions.
XrResult getVulkanExtensions(Call&, XrInstance, XrSystemId, std::uint32_t, std::uint32_t*, char*);
XrResult getVulkanGraphicsDevice(Call&, XrInstance, XrSystemId, VkInstance, VkPhysicalDevice*);

// XR_KHR_convert_timespec_time
XrResult convertTimespecTimeToTime(Call&, XrInstance, const timespec*, XrTime*);
XrResult convertTimeToTimespecTime(Call&, XrInstance, XrTime, timespec*);

// Session
XrResult createSession(Call&, XrInstance, const XrSessionCreateInfo*, XrSession*);
XrResult destroySession(Call&, XrSession);
XrResult beginSession(Call&, XrSession, const XrSessionBeginInfo*);
XrResult endSession(Call&, XrSession);
XrResult requestExitSession(Call&, XrSession);

// Spaces and views
XrResult enumerateReferenceSpaces(Call&, XrSession, std::uint32_t, std::uint32_t*, XrReferenceSpaceType*);
XrResult createReferenceSpace(Call&, XrSession, const XrReferenceSpaceCreateInfo*, XrSpace*);
XrResult getStationaryReferenceSpaceGenerationId(Call&, XrSession,
                                                 const XrStationaryReferenceSpaceGenerationIdGetInfoEXT*,
                                                 XrStationaryReferenceSpaceGenerationIdResultEXT*);
XrResult getReferenceSpaceBoundsRect(Call&, XrSession, XrReferenceSpaceType, XrExtent2Df*);
XrResult createActionSpace(Call&, XrSession, const XrActionSpaceCreateInfo*, XrSpace*);
XrResult locateSpace(Call&, XrSpace, XrSpace, XrTime, XrSpaceLocation*);
XrResult locateViews(Call&, XrSession, const XrViewLocateInfo*, XrViewState*, std::uint32_t, std::uint32_t*,
                     XrView*);

// XR_KHR_visibility_mask
XrResult getVisibilityMask(Call&, XrSession, XrViewConfigurationType, std::uint32_t, XrVisibilityMaskTypeKHR,
                           XrVisibilityMaskKHR*);

// Swapchains
XrResult enumerateSwapchainFormats(Call&, XrSession, std::uint32_t, std::uint32_t*, std::int64_t*);
XrResult createSwapchain(Call&, XrSession, const XrSwapchainCreateInfo*, XrSwapchain*);
XrResult enumerateSwapchainImages(Call&, XrSwapchain, std::uint32_t, std::uint32_t*,
                                  XrSwapchainImageBaseHeader*);
XrResult acquireSwapchainImage(Call&, XrSwapchain, const XrSwapchainImageAcquireInfo*, std::uint32_t*);
XrResult waitSwapchainImage(Call&, XrSwapchain, const XrSwapchainImageWaitInfo*);
XrResult releaseSwapchainImage(Call&, XrSwapchain, const XrSwapchainImageReleaseInfo*);

// Frames
XrResult waitFrame(Call&, XrSession, const XrFrameWaitInfo*, XrFrameState*);
XrResult beginFrame(Call&, XrSession, const XrFrameBeginInfo*);
XrResult endFrame(Call&, XrSession, const XrFrameEndInfo*);

// Actions
XrResult createActionSet(Call&, XrInstance, const XrActionSetCreateInfo*, XrActionSet*);
XrResult createAction(Call&, XrActionSet, const XrActionCreateInfo*, XrAction*);
XrResult suggestInteractionProfileBindings(Call&, XrInstance, const XrInteractionProfileSuggestedBinding*);
XrResult attachSessionActionSets(Call&, XrSession, const XrSessionActionSetsAttachInfo*);
XrResult getCurrentInteractionProfile(Call&, XrSession, XrPath, XrInteractionProfileState*);
XrResult getActionStateBoolean(Call&, XrSession, const XrActionStateGetInfo*, XrActionStateBoolean*);
XrResult getActionStateFloat(Call&, XrSession, const XrActionStateGetInfo*, XrActionStateFloat*);
XrResult getActionStateVector2f(Call&, XrSession, const XrActionStateGetInfo*, XrActionStateVector2f*);
XrResult getActionStatePose(Call&, XrSession, const XrActionStateGetInfo*, XrActionStatePose*);
XrResult syncActions(Call&, XrSession, const XrActionsSyncInfo*);
XrResult enumerateBoundSourcesForAction(Call&, XrSession, const XrBoundSourcesForActionEnumerateInfo*,
                                        std::uint32_t, std::uint32_t*, XrPath*);
XrResult getInputSourceLocalizedName(Call&, XrSession, const XrInputSourceLocalizedNameGetInfo*,
                                     std::uint32_t, std::uint32_t*, char*);
XrResult applyHapticFeedback(Call&, XrSession, const XrHapticActionInfo*, const XrHapticBaseHeader*);
XrResult stopHapticFeedback(Call&, XrSession, const XrHapticActionInfo*);

// XR_FB_display_refresh_rate
XrResult enumerateDisplayRefreshRates(Call&, XrSession, std::uint32_t, std::uint32_t*, float*);
XrResult getDisplayRefreshRate(Call&, XrSession, float*);
XrResult requestDisplayRefreshRate(Call&, XrSession, float);

// XR_EXT_conformance_automation
XrResult setInputDeviceActive(Call&, XrSession, XrPath, XrPath, XrBool32);
XrResult setInputDeviceStateBool(Call&, XrSession, XrPath, XrPath, XrBool32);
XrResult setInputDeviceStateFloat(Call&, XrSession, XrPath, XrPath, float);
XrResult setInputDeviceStateVector2f(Call&, XrSession, XrPath, XrPath, XrVector2f);
XrResult setInputDeviceLocation(Call&, XrSession, XrPath, XrPath, XrSpace, XrPosef);

// XR_EXT_hand_tracking
XrResult createHandTracker(Call&, XrSession, const XrHandTrackerCreateInfoEXT*, XrHandTrackerEXT*);
XrResult locateHandJoints(Call&, XrHandTrackerEXT, const XrHandJointsLocateInfoEXT*,
                          XrHandJointLocationsEXT*);

// XR_EXT_debug_utils
XrResult setDebugUtilsObjectName(Call&, XrInstance, const XrDebugUtilsObjectNameInfoEXT*);
XrResult createDebugUtilsMessenger(Call&, XrInstance, const XrDebugUtilsMessengerCreateInfoEXT*,
                                   XrDebugUtilsMessengerEXT*);
XrResult submitDebugUtilsMessage(Call&, XrInstance, XrDebugUtilsMessageSeverityFlagsEXT,
                                 XrDebugUtilsMessageTypeFlagsEXT,
                                 const XrDebugUtilsMessengerCallbackDataEXT*);
XrResult sessionBeginDebugUtilsLabelRegion(Call&, XrSession, const XrDebugUtilsLabelEXT*);
XrResult sessionEndDebugUtilsLabelRegion(Call&, XrSession);
XrResult sessionInsertDebugUtilsLabel(Call&, XrSession, const XrDebugUtilsLabelEXT*);

}  // namespace xrmock
