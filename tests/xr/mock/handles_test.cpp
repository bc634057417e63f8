// Calls every function with handles that it must reject: null, invented, of another type, destroyed, lost.
// The runtime checks the handle first, so the other arguments may be empty.
#include <cstring>
#include <functional>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

struct Function {
    const char* name;
    std::function<XrResult(void*)> call;  // calls the function with this handle
};

template <class Handle>
Handle as(void* handle) {
    return static_cast<Handle>(handle);
}

// Functions whose first argument is an XrInstance. Excludes xrDestroyInstance, because the loader shuts
// down whatever the handle is; negotiation_test.cpp tests this function without the loader.
std::vector<Function> instanceFunctions() {
    return {
        {"xrGetInstanceProperties",
         [](void* h) { return xrGetInstanceProperties(as<XrInstance>(h), nullptr); }},
        {"xrPollEvent", [](void* h) { return xrPollEvent(as<XrInstance>(h), nullptr); }},
        {"xrResultToString",
         [](void* h) { return xrResultToString(as<XrInstance>(h), XR_SUCCESS, nullptr); }},
        {"xrStructureTypeToString",
         [](void* h) { return xrStructureTypeToString(as<XrInstance>(h), XR_TYPE_UNKNOWN, nullptr); }},
        {"xrGetSystem", [](void* h) { return xrGetSystem(as<XrInstance>(h), nullptr, nullptr); }},
        {"xrGetSystemProperties",
         [](void* h) { return xrGetSystemProperties(as<XrInstance>(h), 0, nullptr); }},
        {"xrEnumerateEnvironmentBlendModes",
         [](void* h) {
             return xrEnumerateEnvironmentBlendModes(
                 as<XrInstance>(h), 0, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO, 0, nullptr, nullptr);
         }},
        {"xrEnumerateViewConfigurations",
         [](void* h) { return xrEnumerateViewConfigurations(as<XrInstance>(h), 0, 0, nullptr, nullptr); }},
        {"xrGetViewConfigurationProperties",
         [](void* h) {
             return xrGetViewConfigurationProperties(as<XrInstance>(h), 0,
                                                     XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO, nullptr);
         }},
        {"xrEnumerateViewConfigurationViews",
         [](void* h) {
             return xrEnumerateViewConfigurationViews(
                 as<XrInstance>(h), 0, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO, 0, nullptr, nullptr);
         }},
        {"xrStringToPath", [](void* h) { return xrStringToPath(as<XrInstance>(h), nullptr, nullptr); }},
        {"xrPathToString", [](void* h) { return xrPathToString(as<XrInstance>(h), 0, 0, nullptr, nullptr); }},
        {"xrCreateSession", [](void* h) { return xrCreateSession(as<XrInstance>(h), nullptr, nullptr); }},
        {"xrCreateActionSet", [](void* h) { return xrCreateActionSet(as<XrInstance>(h), nullptr, nullptr); }},
        {"xrSuggestInteractionProfileBindings",
         [](void* h) { return xrSuggestInteractionProfileBindings(as<XrInstance>(h), nullptr); }},
    };
}

// Functions whose first argument is an XrSession or a child of a session.
std::vector<Function> sessionFunctions() {
    return {
        {"xrDestroySession", [](void* h) { return xrDestroySession(as<XrSession>(h)); }},
        {"xrBeginSession", [](void* h) { return xrBeginSession(as<XrSession>(h), nullptr); }},
        {"xrEndSession", [](void* h) { return xrEndSession(as<XrSession>(h)); }},
        {"xrRequestExitSession", [](void* h) { return xrRequestExitSession(as<XrSession>(h)); }},
        {"xrEnumerateReferenceSpaces",
         [](void* h) { return xrEnumerateReferenceSpaces(as<XrSession>(h), 0, nullptr, nullptr); }},
        {"xrCreateReferenceSpace",
         [](void* h) { return xrCreateReferenceSpace(as<XrSession>(h), nullptr, nullptr); }},
        {"xrGetReferenceSpaceBoundsRect",
         [](void* h) {
             return xrGetReferenceSpaceBoundsRect(as<XrSession>(h), XR_REFERENCE_SPACE_TYPE_VIEW, nullptr);
         }},
        {"xrCreateActionSpace",
         [](void* h) { return xrCreateActionSpace(as<XrSession>(h), nullptr, nullptr); }},
        {"xrLocateViews",
         [](void* h) { return xrLocateViews(as<XrSession>(h), nullptr, nullptr, 0, nullptr, nullptr); }},
        {"xrEnumerateSwapchainFormats",
         [](void* h) { return xrEnumerateSwapchainFormats(as<XrSession>(h), 0, nullptr, nullptr); }},
        {"xrCreateSwapchain", [](void* h) { return xrCreateSwapchain(as<XrSession>(h), nullptr, nullptr); }},
        {"xrWaitFrame", [](void* h) { return xrWaitFrame(as<XrSession>(h), nullptr, nullptr); }},
        {"xrBeginFrame", [](void* h) { return xrBeginFrame(as<XrSession>(h), nullptr); }},
        {"xrEndFrame", [](void* h) { return xrEndFrame(as<XrSession>(h), nullptr); }},
        {"xrAttachSessionActionSets",
         [](void* h) { return xrAttachSessionActionSets(as<XrSession>(h), nullptr); }},
        {"xrGetCurrentInteractionProfile",
         [](void* h) { return xrGetCurrentInteractionProfile(as<XrSession>(h), 0, nullptr); }},
        {"xrGetActionStateBoolean",
         [](void* h) { return xrGetActionStateBoolean(as<XrSession>(h), nullptr, nullptr); }},
        {"xrGetActionStateFloat",
         [](void* h) { return xrGetActionStateFloat(as<XrSession>(h), nullptr, nullptr); }},
        {"xrGetActionStateVector2f",
         [](void* h) { return xrGetActionStateVector2f(as<XrSession>(h), nullptr, nullptr); }},
        {"xrGetActionStatePose",
         [](void* h) { return xrGetActionStatePose(as<XrSession>(h), nullptr, nullptr); }},
        {"xrSyncActions", [](void* h) { return xrSyncActions(as<XrSession>(h), nullptr); }},
        {"xrEnumerateBoundSourcesForAction",
         [](void* h) {
             return xrEnumerateBoundSourcesForAction(as<XrSession>(h), nullptr, 0, nullptr, nullptr);
         }},
        {"xrGetInputSourceLocalizedName",
         [](void* h) {
             return xrGetInputSourceLocalizedName(as<XrSession>(h), nullptr, 0, nullptr, nullptr);
         }},
        {"xrApplyHapticFeedback",
         [](void* h) { return xrApplyHapticFeedback(as<XrSession>(h), nullptr, nullptr); }},
        {"xrStopHapticFeedback", [](void* h) { return xrStopHapticFeedback(as<XrSession>(h), nullptr); }},
    };
}

std::vector<Function> spaceFunctions(XrSpace other) {
    return {
        {"xrDestroySpace", [](void* h) { return xrDestroySpace(as<XrSpace>(h)); }},
        {"xrLocateSpace", [other](void* h) { return xrLocateSpace(as<XrSpace>(h), other, 1, nullptr); }},
        {"xrLocateSpace, base",
         [other](void* h) { return xrLocateSpace(other, as<XrSpace>(h), 1, nullptr); }},
    };
}

std::vector<Function> swapchainFunctions() {
    return {
        {"xrDestroySwapchain", [](void* h) { return xrDestroySwapchain(as<XrSwapchain>(h)); }},
        {"xrEnumerateSwapchainImages",
         [](void* h) { return xrEnumerateSwapchainImages(as<XrSwapchain>(h), 0, nullptr, nullptr); }},
        {"xrAcquireSwapchainImage",
         [](void* h) { return xrAcquireSwapchainImage(as<XrSwapchain>(h), nullptr, nullptr); }},
        {"xrWaitSwapchainImage", [](void* h) { return xrWaitSwapchainImage(as<XrSwapchain>(h), nullptr); }},
        {"xrReleaseSwapchainImage",
         [](void* h) { return xrReleaseSwapchainImage(as<XrSwapchain>(h), nullptr); }},
    };
}

std::vector<Function> actionFunctions() {
    return {
        {"xrDestroyActionSet", [](void* h) { return xrDestroyActionSet(as<XrActionSet>(h)); }},
        {"xrCreateAction", [](void* h) { return xrCreateAction(as<XrActionSet>(h), nullptr, nullptr); }},
        {"xrDestroyAction", [](void* h) { return xrDestroyAction(as<XrAction>(h)); }},
    };
}

// Functions of extensions, called through their pointers.
template <class Function, class Handle, class... Arguments>
std::function<XrResult(void*)> extension(XrInstance instance, const char* name, Arguments... arguments) {
    const auto function = load<Function>(instance, name);
    return [=](void* h) { return function(as<Handle>(h), arguments...); };
}

std::vector<Function> extensionFunctions(XrInstance i) {
    return {
        {"xrGetVulkanInstanceExtensionsKHR",
         extension<PFN_xrGetVulkanInstanceExtensionsKHR, XrInstance>(i, "xrGetVulkanInstanceExtensionsKHR",
                                                                     XrSystemId{0}, 0U, nullptr, nullptr)},
        {"xrGetVulkanDeviceExtensionsKHR",
         extension<PFN_xrGetVulkanDeviceExtensionsKHR, XrInstance>(i, "xrGetVulkanDeviceExtensionsKHR",
                                                                   XrSystemId{0}, 0U, nullptr, nullptr)},
        {"xrGetVulkanGraphicsDeviceKHR",
         extension<PFN_xrGetVulkanGraphicsDeviceKHR, XrInstance>(i, "xrGetVulkanGraphicsDeviceKHR",
                                                                 XrSystemId{0}, nullptr, nullptr)},
        {"xrGetVulkanGraphicsRequirementsKHR",
         extension<PFN_xrGetVulkanGraphicsRequirementsKHR, XrInstance>(
             i, "xrGetVulkanGraphicsRequirementsKHR", XrSystemId{0}, nullptr)},
        {"xrGetVulkanGraphicsRequirements2KHR",
         extension<PFN_xrGetVulkanGraphicsRequirements2KHR, XrInstance>(
             i, "xrGetVulkanGraphicsRequirements2KHR", XrSystemId{0}, nullptr)},
        {"xrCreateVulkanInstanceKHR", extension<PFN_xrCreateVulkanInstanceKHR, XrInstance>(
                                          i, "xrCreateVulkanInstanceKHR", nullptr, nullptr, nullptr)},
        {"xrCreateVulkanDeviceKHR", extension<PFN_xrCreateVulkanDeviceKHR, XrInstance>(
                                        i, "xrCreateVulkanDeviceKHR", nullptr, nullptr, nullptr)},
        {"xrGetVulkanGraphicsDevice2KHR", extension<PFN_xrGetVulkanGraphicsDevice2KHR, XrInstance>(
                                              i, "xrGetVulkanGraphicsDevice2KHR", nullptr, nullptr)},
        {"xrConvertTimespecTimeToTimeKHR", extension<PFN_xrConvertTimespecTimeToTimeKHR, XrInstance>(
                                               i, "xrConvertTimespecTimeToTimeKHR", nullptr, nullptr)},
        {"xrConvertTimeToTimespecTimeKHR", extension<PFN_xrConvertTimeToTimespecTimeKHR, XrInstance>(
                                               i, "xrConvertTimeToTimespecTimeKHR", XrTime{1}, nullptr)},
    };
}

class Handles : public MockTest {
  protected:
    void expectRefused(const std::vector<Function>& functions, void* handle, const char* what) {
        for (const Function& function : functions)
            EXPECT_EQ(function.call(handle), XR_ERROR_HANDLE_INVALID) << function.name << ", " << what;
    }
    // Expects `result` from every function except those that destroy.
    void expectLost(const std::vector<Function>& functions, void* handle, XrResult result) {
        for (const Function& function : functions) {
            if (std::strncmp(function.name, "xrDestroy", 9) == 0) continue;
            EXPECT_EQ(function.call(handle), result) << function.name;
        }
    }
    // `other_type` is a valid handle of a type that none of the functions accepts.
    void expectAllRefused(const std::vector<Function>& functions, void* other_type) {
        expectRefused(functions, nullptr, "null");
        expectRefused(functions, reinterpret_cast<void*>(~std::uintptr_t{0}), "all ones");
        expectRefused(functions, reinterpret_cast<void*>(std::uintptr_t{0x1234'5678'9abc}), "invented");
        expectRefused(functions, other_type, "of another type");
    }
};

TEST_F(Handles, OfInstancesAreChecked) {
    startSession();
    expectAllRefused(instanceFunctions(), session_);
    expectAllRefused(extensionFunctions(instance_), session_);
}

TEST_F(Handles, OfSessionsAreChecked) {
    startSession();
    expectAllRefused(sessionFunctions(), stage_);
    ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
    expectRefused(sessionFunctions(), session_, "destroyed");
}

TEST_F(Handles, OfSpacesAreChecked) {
    startSession();
    expectAllRefused(spaceFunctions(stage_), session_);
    const XrSpace gone = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    ASSERT_EQ(xrDestroySpace(gone), XR_SUCCESS);
    expectRefused(spaceFunctions(stage_), gone, "destroyed");
    const XrSpace alive = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    EXPECT_NE(alive, gone);
    expectRefused(spaceFunctions(stage_), gone, "destroyed, its place taken");
    ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
    expectRefused(spaceFunctions(stage_), alive, "gone with its session");
}

TEST_F(Handles, OfSwapchainsAreChecked) {
    startSession();
    expectAllRefused(swapchainFunctions(), stage_);
    const XrSwapchain swapchain = createSwapchain(swapchainInfo()).handle;
    ASSERT_EQ(xrDestroySwapchain(swapchain), XR_SUCCESS);
    expectRefused(swapchainFunctions(), swapchain, "destroyed");
}

TEST_F(Handles, OfActionsAreChecked) {
    startSession();
    expectAllRefused(actionFunctions(), session_);
    auto info = makeStruct<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::strcpy(info.actionSetName, "set");
    std::strcpy(info.localizedActionSetName, "set");
    XrActionSet set = XR_NULL_HANDLE;
    ASSERT_EQ(xrCreateActionSet(instance_, &info, &set), XR_SUCCESS);
    ASSERT_EQ(xrDestroyActionSet(set), XR_SUCCESS);
    expectRefused(actionFunctions(), set, "destroyed");
}

TEST_F(Handles, AreInvalidAfterTheirInstanceIsDestroyed) {
    startSession();
    const XrInstance gone = instance_;
    destroyInstance();
    start();  // the loader only forwards calls while an instance exists
    expectRefused(instanceFunctions(), gone, "destroyed");
    expectRefused(sessionFunctions(), session_, "gone with its instance");
    expectRefused(spaceFunctions(stage_), stage_, "gone with its instance");
}

TEST_F(Handles, OfALostSessionCanOnlyBeDestroyed) {
    setScript(R"({"version": 2, "events": [{"frame": 1, "session_loss": {"lost_after_s": 0}}]})");
    startRunning();
    const XrSwapchain swapchain = createSwapchain(swapchainInfo()).handle;
    ASSERT_EQ(waitFrame(), XR_ERROR_SESSION_LOST);
    expectLost(sessionFunctions(), session_, XR_ERROR_SESSION_LOST);
    expectLost(spaceFunctions(stage_), stage_, XR_ERROR_SESSION_LOST);
    expectLost(swapchainFunctions(), swapchain, XR_ERROR_SESSION_LOST);
    EXPECT_EQ(xrDestroySpace(stage_), XR_SUCCESS);
    EXPECT_EQ(xrDestroySwapchain(swapchain), XR_SUCCESS);
    EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
    const XrGraphicsBindingVulkan2KHR graphics = binding();
    EXPECT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
}

TEST_F(Handles, OfALostInstanceCanOnlyBeDestroyed) {
    setScript(R"({"version": 2, "events": [{"frame": 1, "instance_loss": {"lost_after_s": 0}}]})");
    startRunning();
    const XrSwapchain swapchain = createSwapchain(swapchainInfo()).handle;
    const auto functions = extensionFunctions(instance_);
    while (waitFrame() != XR_ERROR_INSTANCE_LOST)
        beginFrame();
    expectLost(instanceFunctions(), instance_, XR_ERROR_INSTANCE_LOST);
    expectLost(functions, instance_, XR_ERROR_INSTANCE_LOST);
    expectLost(sessionFunctions(), session_, XR_ERROR_INSTANCE_LOST);
    expectLost(spaceFunctions(stage_), stage_, XR_ERROR_INSTANCE_LOST);
    expectLost(swapchainFunctions(), swapchain, XR_ERROR_INSTANCE_LOST);
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrDestroyInstance", &function), XR_SUCCESS);
    EXPECT_EQ(xrDestroySwapchain(swapchain), XR_SUCCESS);
    EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
    destroyInstance();
}

}  // namespace
}  // namespace mock_test
