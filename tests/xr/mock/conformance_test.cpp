// Rules that the conformance suite's layer checks in every call: which calls use the Vulkan queue, which
// functions exist, which session states follow each other, and which members of a structure stay unchanged.
#include <cstring>
#include <random>
#include <set>

#include "tests/xr/mock/every_function.h"

namespace mock_test {
namespace {

class Conformance : public MockTest {};

// --- Vulkan functions passed by the application, which count the uses of the queue ---

int queue_uses = 0;
PFN_vkVoidFunction real(VkDevice device, const char* name) {
    return vkGetDeviceProcAddr(device, name);
}
VkDevice hooked_device = VK_NULL_HANDLE;

VKAPI_ATTR VkResult VKAPI_CALL countedSubmit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* infos,
                                             VkFence fence) {
    ++queue_uses;
    return reinterpret_cast<PFN_vkQueueSubmit>(real(hooked_device, "vkQueueSubmit"))(queue, count, infos,
                                                                                     fence);
}
VKAPI_ATTR VkResult VKAPI_CALL countedQueueWait(VkQueue queue) {
    ++queue_uses;
    return reinterpret_cast<PFN_vkQueueWaitIdle>(real(hooked_device, "vkQueueWaitIdle"))(queue);
}
VKAPI_ATTR VkResult VKAPI_CALL countedDeviceWait(VkDevice device) {
    ++queue_uses;
    return reinterpret_cast<PFN_vkDeviceWaitIdle>(real(device, "vkDeviceWaitIdle"))(device);
}
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL hookedDeviceProcAddr(VkDevice device, const char* name) {
    hooked_device = device;
    const std::string_view wanted = name;
    if (wanted == "vkQueueSubmit") return reinterpret_cast<PFN_vkVoidFunction>(countedSubmit);
    if (wanted == "vkQueueWaitIdle") return reinterpret_cast<PFN_vkVoidFunction>(countedQueueWait);
    if (wanted == "vkDeviceWaitIdle") return reinterpret_cast<PFN_vkVoidFunction>(countedDeviceWait);
    return real(device, name);
}
bool compute_only = false;  // true: report every queue of the GPU as compute-only
VKAPI_ATTR void VKAPI_CALL computeFamily(VkPhysicalDevice, std::uint32_t* count,
                                         VkQueueFamilyProperties* families) {
    *count = 1;
    if (families != nullptr) *families = {VK_QUEUE_COMPUTE_BIT, 1, 0, {1, 1, 1}};
}
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL hookedInstanceProcAddr(VkInstance instance, const char* name) {
    if (compute_only && std::string_view(name) == "vkGetPhysicalDeviceQueueFamilyProperties")
        return reinterpret_cast<PFN_vkVoidFunction>(computeFamily);
    if (std::string_view(name) == "vkGetDeviceProcAddr")
        return reinterpret_cast<PFN_vkVoidFunction>(hookedDeviceProcAddr);
    return vkGetInstanceProcAddr(instance, name);
}

class QueueUse : public Conformance {
  protected:
    void startHooked() {
        start();
        auto requirements =
            makeStruct<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
        load<PFN_xrGetVulkanGraphicsRequirements2KHR>(instance_, "xrGetVulkanGraphicsRequirements2KHR")(
            instance_, system_, &requirements);
        VkInstanceCreateInfo vk_instance_info{};
        vk_instance_info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
        auto instance_info =
            makeStruct<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
        instance_info.systemId = system_;
        instance_info.pfnGetInstanceProcAddr = hookedInstanceProcAddr;
        instance_info.vulkanCreateInfo = &vk_instance_info;
        VkResult outcome = VK_ERROR_UNKNOWN;
        ASSERT_EQ(load<PFN_xrCreateVulkanInstanceKHR>(instance_, "xrCreateVulkanInstanceKHR")(
                      instance_, &instance_info, &vk_instance_, &outcome),
                  XR_SUCCESS);
        const XrVulkanGraphicsDeviceGetInfoKHR get_info{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, nullptr,
                                                        system_, vk_instance_};
        ASSERT_EQ(load<PFN_xrGetVulkanGraphicsDevice2KHR>(instance_, "xrGetVulkanGraphicsDevice2KHR")(
                      instance_, &get_info, &vk_physical_device_),
                  XR_SUCCESS);
        const float priority = 1;
        const VkDeviceQueueCreateInfo queue_info{
            VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, vk_queue_family_, 1, &priority};
        VkDeviceCreateInfo vk_device_info{};
        vk_device_info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
        vk_device_info.queueCreateInfoCount = 1;
        vk_device_info.pQueueCreateInfos = &queue_info;
        auto device_info = makeStruct<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
        device_info.systemId = system_;
        device_info.pfnGetInstanceProcAddr = hookedInstanceProcAddr;
        device_info.vulkanPhysicalDevice = vk_physical_device_;
        device_info.vulkanCreateInfo = &vk_device_info;
        ASSERT_EQ(load<PFN_xrCreateVulkanDeviceKHR>(instance_, "xrCreateVulkanDeviceKHR")(
                      instance_, &device_info, &vk_device_, &outcome),
                  XR_SUCCESS);
        vkGetDeviceQueue(vk_device_, vk_queue_family_, 0, &vk_queue_);
    }
    // How often the calls in `body` use the queue.
    template <class Body>
    int usesIn(Body body) {
        const int before = queue_uses;
        body();
        return queue_uses - before;
    }
};

// XR_KHR_vulkan_enable2, "Concurrency": the runtime may use the queue only in xrBeginFrame, xrEndFrame,
// xrAcquireSwapchainImage and xrReleaseSwapchainImage.
TEST_F(QueueUse, HappensOnlyInCallsThatMayUseTheQueue) {
    startHooked();
    const XrGraphicsBindingVulkan2KHR graphics = binding();
    Swapchain swapchain;
    EXPECT_EQ(usesIn([&] {
                  ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
                  stage_ = createSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
                  const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr,
                                                XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
                  ASSERT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
                  swapchain = createSwapchain(swapchainInfo());  // also enumerates its images
              }),
              0);
    const int in_acquire_and_end = usesIn([&] {
        std::uint32_t index = 0;
        const XrSwapchainImageWaitInfo wait{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, XR_INFINITE_DURATION};
        ASSERT_EQ(xrAcquireSwapchainImage(swapchain.handle, nullptr, &index), XR_SUCCESS);
        EXPECT_EQ(usesIn([&] { ASSERT_EQ(xrWaitSwapchainImage(swapchain.handle, &wait), XR_SUCCESS); }), 0);
        ASSERT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_SUCCESS);
        frame();
    });
    EXPECT_GT(in_acquire_and_end, 0);  // otherwise nothing was counted
    EXPECT_EQ(usesIn([&] {
                  waitFrame();
                  states();
                  EXPECT_EQ(xrDestroySwapchain(swapchain.handle), XR_SUCCESS);
                  EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
              }),
              0);
}

// XR_KHR_vulkan_enable2, "Queue Selection".
TEST_F(QueueUse, TheQueueHasGraphics) {
    startHooked();
    const XrGraphicsBindingVulkan2KHR graphics = binding();
    compute_only = true;
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    compute_only = false;
    EXPECT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
}

// --- xrGetInstanceProcAddr ---

constexpr const char* kEveryName[] = {
#define MOCK_TEST_NAME(function, ...) "xr" #function,
    MOCK_TEST_EVERY_FUNCTION(MOCK_TEST_NAME)
#undef MOCK_TEST_NAME
};
bool isExtension(std::string_view name) {
    return name.ends_with("KHR") || name.ends_with("EXT") || name.ends_with("FB");
}

TEST_F(Conformance, FunctionsAreFoundOnlyWhereTheyMayBeCalled) {
    extensions_ = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
    start();
    const PFN_xrGetInstanceProcAddr look_up = runtimeEntry();
    ASSERT_NE(look_up, nullptr);
    const auto garbage = reinterpret_cast<PFN_xrVoidFunction>(&queue_uses);
    for (const char* name : kEveryName) {
        PFN_xrVoidFunction function = garbage;
        EXPECT_EQ(look_up(XR_NULL_HANDLE, name, &function), XR_ERROR_HANDLE_INVALID) << name;
        EXPECT_EQ(function, nullptr) << name;
        const bool there = !isExtension(name) || std::strstr(name, "Vulkan") != nullptr;
        if (there && isExtension(name)) continue;  // the name may belong to either Vulkan extension
        function = garbage;
        EXPECT_EQ(look_up(instance_, name, &function), there ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED)
            << name;
        EXPECT_EQ(function != nullptr, there) << name;
        function = garbage;
        EXPECT_EQ(look_up(reinterpret_cast<XrInstance>(std::uintptr_t{0x1234}), name, &function),
                  XR_ERROR_HANDLE_INVALID)
            << name;
        EXPECT_EQ(function, nullptr) << name;
    }
    for (const char* name : {"", "x", "xr", "xr*", "xrNothing", "xrGetSystemX", "xrGetSystem more", "\xff"}) {
        PFN_xrVoidFunction function = garbage;
        EXPECT_EQ(look_up(instance_, name, &function), XR_ERROR_FUNCTION_UNSUPPORTED) << name;
        EXPECT_EQ(function, nullptr) << name;
    }
    PFN_xrVoidFunction function = garbage;
    EXPECT_EQ(look_up(instance_, nullptr, &function), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(look_up(instance_, "xrGetSystem", nullptr), XR_ERROR_VALIDATION_FAILURE);
}

// --- Session states ---

// OpenXR 1.0, "Session Lifecycle": the allowed transitions.
bool mayFollow(XrSessionState from, XrSessionState to) {
    static const std::set<std::pair<XrSessionState, XrSessionState>> kAllowed{
        {XR_SESSION_STATE_UNKNOWN, XR_SESSION_STATE_IDLE},
        {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY},
        {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_EXITING},
        {XR_SESSION_STATE_READY, XR_SESSION_STATE_SYNCHRONIZED},
        {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE},
        {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING},
        {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED},
        {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED},
        {XR_SESSION_STATE_FOCUSED, XR_SESSION_STATE_VISIBLE},
        {XR_SESSION_STATE_STOPPING, XR_SESSION_STATE_IDLE}};
    return to == XR_SESSION_STATE_LOSS_PENDING || kAllowed.contains({from, to});
}

// The target state changes often and at random. No state may be skipped, and a state that requires a call by
// the application is entered only after that call.
TEST_F(Conformance, StatesFollowOneAnother) {
    std::mt19937 random(11);
    constexpr const char* kTargets[] = {"focused", "visible", "synchronized", "stopped"};
    std::string keys;
    for (int i = 0; i < 200; ++i) {
        keys += (i == 0 ? "{\"t_s\": " : ", {\"t_s\": ") + std::to_string(i * 0.03) + ", \"state\": \"" +
                kTargets[random() % 4] + "\"}";
    }
    setScript("{\"version\": 1, \"session\": [" + keys + ", {\"t_s\": 6.5, \"state\": \"exiting\"}]}");
    startSession();
    bool running = false;
    int frames = 0, entered = 0;
    XrTime last_time = 0;
    XrSessionState state = XR_SESSION_STATE_UNKNOWN;
    for (int step = 0; step < 5000 && state != XR_SESSION_STATE_EXITING; ++step) {
        for (const XrSessionState next : states()) {
            EXPECT_TRUE(mayFollow(state, next)) << state << " -> " << next;
            EXPECT_EQ(running, next >= XR_SESSION_STATE_SYNCHRONIZED && next <= XR_SESSION_STATE_STOPPING);
            state = next;
            ++entered;
            const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr,
                                          XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
            if (next == XR_SESSION_STATE_READY) {
                ASSERT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
                running = true;
            } else if (next == XR_SESSION_STATE_STOPPING) {
                ASSERT_EQ(xrEndSession(session_), XR_SUCCESS);
                running = false;
            }
        }
        if (!running) continue;
        const XrFrameState now = frame();
        EXPECT_GT(now.predictedDisplayTime, last_time);
        last_time = now.predictedDisplayTime;
        ++frames;
    }
    EXPECT_EQ(state, XR_SESSION_STATE_EXITING);
    EXPECT_GT(entered, 50);
    EXPECT_GT(frames, 50);
}

// Every number has a name, known or unknown.
TEST_F(Conformance, ResultsAndStructureTypesHaveNames) {
    start();
    char text[XR_MAX_RESULT_STRING_SIZE];
    for (int value = -60; value < 12; ++value)
        EXPECT_EQ(xrResultToString(instance_, static_cast<XrResult>(value), text), XR_SUCCESS) << value;
    for (int value = 0; value < 70; ++value)
        EXPECT_EQ(xrStructureTypeToString(instance_, static_cast<XrStructureType>(value), text), XR_SUCCESS)
            << value;
}

}  // namespace
}  // namespace mock_test
