// Table of the mock runtime's OpenXR functions, by name. Each entry is a C function that locks the runtime,
// calls the implementation, turns exceptions into an XrResult and delivers debug messages to the application.
#include <algorithm>
#include <cstddef>
#include <cstring>

#include "api/api.h"
#include "scenario/names.h"
#include "world/objects.h"

namespace xrmock {

namespace {

template <std::size_t kSize>
struct Name {
    constexpr Name(const char (&literal)[kSize]) { std::copy_n(literal, kSize, text); }
    char text[kSize];
};

// Returns the handle on which a call acts: its first argument, or 0 if that is not a handle.
template <class First, class... Rest>
std::uint64_t findSubject(First first, Rest...) {
    if constexpr (std::is_pointer_v<First> && !std::is_const_v<std::remove_pointer_t<First>>)
        return handleValue(first);
    else
        return 0;
}

template <Name kName, auto kFunction>
struct Entry;
template <Name kName, class... Arguments, XrResult (*kFunction)(Call&, Arguments...)>
struct Entry<kName, kFunction> {
    static XRAPI_ATTR XrResult XRAPI_CALL call(Arguments... arguments) noexcept {
        const std::uint64_t subject = findSubject(arguments...);
        return guard(
            kName.text,
            [&](Call& context) {
                stallIfScripted(context, subject);
                if (const auto refusal = scriptedRefusal(context, subject)) return *refusal;
                return kFunction(context, arguments...);
            },
            [&](Call& context, XrResult result) {
                Log* const log = runtime().log.get();
                if (log == nullptr) return;
                beginCallLine(*log, context, result, subject);
                (describeArgument(*log, XR_SUCCEEDED(result), arguments), ...);
                endCallLine(*log, context);
            });
    }
};

struct Row {
    const char* name;
    const char* extension;  // null: core
    PFN_xrVoidFunction function;
};

template <Name kName, auto kFunction>
Row row(const char* extension = nullptr) {
    return {kName.text, extension, reinterpret_cast<PFN_xrVoidFunction>(&Entry<kName, kFunction>::call)};
}

// Implements most xrDestroy functions.
template <class T, class Handle>
XrResult destroy(Call& call, Handle handle) {
    runtime().handles.destroy(call.liveOrLost<T>(handle));
    return XR_SUCCESS;
}

constexpr const char* kVulkan = XR_KHR_VULKAN_ENABLE_EXTENSION_NAME;
constexpr const char* kVulkan2 = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
constexpr const char* kTimespec = XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME;
constexpr const char* kAutomation = XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME;
constexpr const char* kVisibilityMask = XR_KHR_VISIBILITY_MASK_EXTENSION_NAME;
constexpr const char* kHands = XR_EXT_HAND_TRACKING_EXTENSION_NAME;
constexpr const char* kDebug = XR_EXT_DEBUG_UTILS_EXTENSION_NAME;
constexpr const char* kRefreshRate = XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME;
constexpr const char* kStationary = XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME;

const Row kRows[] = {
    {"xrGetInstanceProcAddr", nullptr, reinterpret_cast<PFN_xrVoidFunction>(&getInstanceProcAddr)},
    row<"xrEnumerateApiLayerProperties", enumerateApiLayerProperties>(),
    row<"xrEnumerateInstanceExtensionProperties", enumerateInstanceExtensionProperties>(),
    row<"xrCreateInstance", createInstance>(),
    row<"xrDestroyInstance", destroyInstance>(),
    row<"xrGetInstanceProperties", getInstanceProperties>(),
    row<"xrPollEvent", pollEvent>(),
    row<"xrResultToString", resultToString>(),
    row<"xrStructureTypeToString", structureTypeToString>(),
    row<"xrStringToPath", stringToPath>(),
    row<"xrPathToString", pathToString>(),
    row<"xrGetSystem", getSystem>(),
    row<"xrGetSystemProperties", getSystemProperties>(),
    row<"xrEnumerateEnvironmentBlendModes", enumerateEnvironmentBlendModes>(),
    row<"xrEnumerateViewConfigurations", enumerateViewConfigurations>(),
    row<"xrGetViewConfigurationProperties", getViewConfigurationProperties>(),
    row<"xrEnumerateViewConfigurationViews", enumerateViewConfigurationViews>(),
    row<"xrCreateSession", createSession>(),
    row<"xrDestroySession", destroySession>(),
    row<"xrBeginSession", beginSession>(),
    row<"xrEndSession", endSession>(),
    row<"xrRequestExitSession", requestExitSession>(),
    row<"xrEnumerateReferenceSpaces", enumerateReferenceSpaces>(),
    row<"xrCreateReferenceSpace", createReferenceSpace>(),
    row<"xrGetReferenceSpaceBoundsRect", getReferenceSpaceBoundsRect>(),
    row<"xrCreateActionSpace", createActionSpace>(),
    row<"xrLocateSpace", locateSpace>(),
    row<"xrDestroySpace", destroy<Space, XrSpace>>(),
    row<"xrLocateViews", locateViews>(),
    row<"xrEnumerateSwapchainFormats", enumerateSwapchainFormats>(),
    row<"xrCreateSwapchain", createSwapchain>(),
    row<"xrDestroySwapchain", destroy<Swapchain, XrSwapchain>>(),
    row<"xrEnumerateSwapchainImages", enumerateSwapchainImages>(),
    row<"xrAcquireSwapchainImage", acquireSwapchainImage>(),
    row<"xrWaitSwapchainImage", waitSwapchainImage>(),
    row<"xrReleaseSwapchainImage", releaseSwapchainImage>(),
    row<"xrWaitFrame", waitFrame>(),
    row<"xrBeginFrame", beginFrame>(),
    row<"xrEndFrame", endFrame>(),
    row<"xrCreateActionSet", createActionSet>(),
    row<"xrDestroyActionSet", destroy<ActionSet, XrActionSet>>(),
    row<"xrCreateAction", createAction>(),
    row<"xrDestroyAction", destroy<Action, XrAction>>(),
    row<"xrSuggestInteractionProfileBindings", suggestInteractionProfileBindings>(),
    row<"xrAttachSessionActionSets", attachSessionActionSets>(),
    row<"xrGetCurrentInteractionProfile", getCurrentInteractionProfile>(),
    row<"xrGetActionStateBoolean", getActionStateBoolean>(),
    row<"xrGetActionStateFloat", getActionStateFloat>(),
    row<"xrGetActionStateVector2f", getActionStateVector2f>(),
    row<"xrGetActionStatePose", getActionStatePose>(),
    row<"xrSyncActions", syncActions>(),
    row<"xrEnumerateBoundSourcesForAction", enumerateBoundSourcesForAction>(),
    row<"xrGetInputSourceLocalizedName", getInputSourceLocalizedName>(),
    row<"xrApplyHapticFeedback", applyHapticFeedback>(),
    row<"xrStopHapticFeedback", stopHapticFeedback>(),
    row<"xrGetVulkanInstanceExtensionsKHR", getVulkanExtensions>(kVulkan),
    row<"xrGetVulkanDeviceExtensionsKHR", getVulkanExtensions>(kVulkan),
    row<"xrGetVulkanGraphicsDeviceKHR", getVulkanGraphicsDevice>(kVulkan),
    row<"xrGetVulkanGraphicsRequirementsKHR", getVulkanGraphicsRequirements>(kVulkan),
    row<"xrCreateVulkanInstanceKHR", createVulkanInstance>(kVulkan2),
    row<"xrCreateVulkanDeviceKHR", createVulkanDevice>(kVulkan2),
    row<"xrGetVulkanGraphicsDevice2KHR", getVulkanGraphicsDevice2>(kVulkan2),
    row<"xrGetVulkanGraphicsRequirements2KHR", getVulkanGraphicsRequirements>(kVulkan2),
    row<"xrConvertTimespecTimeToTimeKHR", convertTimespecTimeToTime>(kTimespec),
    row<"xrConvertTimeToTimespecTimeKHR", convertTimeToTimespecTime>(kTimespec),
    row<"xrGetVisibilityMaskKHR", getVisibilityMask>(kVisibilityMask),
    row<"xrEnumerateDisplayRefreshRatesFB", enumerateDisplayRefreshRates>(kRefreshRate),
    row<"xrGetDisplayRefreshRateFB", getDisplayRefreshRate>(kRefreshRate),
    row<"xrRequestDisplayRefreshRateFB", requestDisplayRefreshRate>(kRefreshRate),
    row<"xrGetStationaryReferenceSpaceGenerationIdEXT", getStationaryReferenceSpaceGenerationId>(kStationary),
    row<"xrSetInputDeviceActiveEXT", setInputDeviceActive>(kAutomation),
    row<"xrSetInputDeviceStateBoolEXT", setInputDeviceStateBool>(kAutomation),
    row<"xrSetInputDeviceStateFloatEXT", setInputDeviceStateFloat>(kAutomation),
    row<"xrSetInputDeviceStateVector2fEXT", setInputDeviceStateVector2f>(kAutomation),
    row<"xrSetInputDeviceLocationEXT", setInputDeviceLocation>(kAutomation),
    row<"xrCreateHandTrackerEXT", createHandTracker>(kHands),
    row<"xrDestroyHandTrackerEXT", destroy<HandTracker, XrHandTrackerEXT>>(kHands),
    row<"xrLocateHandJointsEXT", locateHandJoints>(kHands),
    row<"xrSetDebugUtilsObjectNameEXT", setDebugUtilsObjectName>(kDebug),
    row<"xrCreateDebugUtilsMessengerEXT", createDebugUtilsMessenger>(kDebug),
    row<"xrDestroyDebugUtilsMessengerEXT", destroy<Messenger, XrDebugUtilsMessengerEXT>>(kDebug),
    row<"xrSubmitDebugUtilsMessageEXT", submitDebugUtilsMessage>(kDebug),
    row<"xrSessionBeginDebugUtilsLabelRegionEXT", sessionBeginDebugUtilsLabelRegion>(kDebug),
    row<"xrSessionEndDebugUtilsLabelRegionEXT", sessionEndDebugUtilsLabelRegion>(kDebug),
    row<"xrSessionInsertDebugUtilsLabelEXT", sessionInsertDebugUtilsLabel>(kDebug),
};

// Functions that can be looked up without an instance.
bool needsNoInstance(const char* name) {
    constexpr const char* kNames[] = {"xrGetInstanceProcAddr", "xrEnumerateApiLayerProperties",
                                      "xrEnumerateInstanceExtensionProperties", "xrCreateInstance"};
    return std::any_of(std::begin(kNames), std::end(kNames),
                       [&](const char* each) { return std::strcmp(each, name) == 0; });
}

XrResult lookUp(Call& call, XrInstance handle, const char* name, PFN_xrVoidFunction* function) {
    requireValid(function != nullptr, "function is null");
    *function = nullptr;
    requireValid(name != nullptr, "name is null");
    if (handle == XR_NULL_HANDLE && !needsNoInstance(name)) return XR_ERROR_HANDLE_INVALID;
    const Instance* instance = handle == XR_NULL_HANDLE ? nullptr : &call.liveOrLost<Instance>(handle);
    for (const Row& each : kRows) {
        if (std::strcmp(each.name, name) != 0) continue;
        if (each.extension != nullptr && !instance->extensions.contains(each.extension)) break;
        *function = each.function;
        return XR_SUCCESS;
    }
    // No debug message here: OpenXR loaders look up every function they know, so this result is normal.
    return XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

bool isRefusable(std::string_view name) {
    return std::any_of(std::begin(kRows), std::end(kRows),
                       [&](const Row& each) { return name == each.name && !needsNoInstance(each.name); });
}

XRAPI_ATTR XrResult XRAPI_CALL getInstanceProcAddr(XrInstance instance, const char* name,
                                                   PFN_xrVoidFunction* function) noexcept {
    return guard(
        "xrGetInstanceProcAddr", [&](Call& call) { return lookUp(call, instance, name, function); },
        [](Call&, XrResult) {});  // not logged: loaders look up every function they know
}

}  // namespace xrmock
