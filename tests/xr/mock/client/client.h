// A small OpenXR client over Vulkan, for tests that use the mock runtime through the system's loader.
#pragma once

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#include <time.h>
#include <vulkan/vulkan.h>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/temp_folder.h"

namespace mock_test {

// Returns when the thread with this id sleeps in a system call. The thread sets the id itself. Throws
// std::runtime_error after a minute.
void waitUntilAsleep(const std::atomic<int>& thread);

template <class Function>
Function load(XrInstance instance, const char* name) {
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance, name, &function), XR_SUCCESS) << name;
    return reinterpret_cast<Function>(function);
}

// A structure with its type set and everything else zero.
template <class Struct>
Struct makeStruct(XrStructureType type) {
    Struct result{};
    result.type = type;
    return result;
}

// The runtime's own entry point. Calls through it bypass the loader, which checks arguments less strictly
// than a runtime must.
PFN_xrGetInstanceProcAddr runtimeEntry();

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};
constexpr XrPosef kAhead{{0, 0, 0, 1}, {0, 1.6F, -5}};  // in front of the resting head
constexpr auto kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;

// The extensions that the runtime and the loader offer together.
std::vector<std::string> offeredExtensions();

struct Swapchain {
    XrSwapchain handle = XR_NULL_HANDLE;
    std::vector<VkImage> images;
    std::uint32_t width = 0, height = 0;
};
// The whole area of a layer of a swapchain's images.
XrSwapchainSubImage whole(const Swapchain& swapchain, std::uint32_t layer = 0);
XrCompositionLayerQuad quadLayer(XrSpace space, const Swapchain& swapchain, XrPosef pose, XrExtent2Df size_m);

template <class Layer>
const XrCompositionLayerBaseHeader* header(const Layer& layer) {
    return reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
}

// Each test has an empty folder and at most one instance and session. It sets its environment before start().
// TearDown destroys everything and checks that Vulkan has reported no message.
class MockTest : public testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;

    void setVariable(const std::string& name, const std::string& value);
    void setScript(const std::string& text);
    std::filesystem::path file(const std::string& name) const { return folder_ / name; }

    XrResult tryInstance(const void* next = nullptr);  // xrCreateInstance
    void destroyInstance();
    void start();        // creates instance and system
    void startVulkan();  // also Vulkan instance, device and queue
    void destroyVulkanInstance();
    void destroyAll();    // OpenXR and Vulkan
    void startSession();  // also a session with a STAGE space
    void startRunning();  // also calls xrBeginSession
    XrResult beginSession();
    void startFocused();  // also runs frames until FOCUSED

    // The next queued event of the given type. Skips others.
    std::optional<XrEventDataBuffer> poll(XrStructureType type);
    // All queued session states.
    std::vector<XrSessionState> states();
    // Runs one frame with these layers and returns its state.
    XrFrameState frame(const std::vector<const XrCompositionLayerBaseHeader*>& layers = {});
    XrResult waitFrame(XrFrameState* state = nullptr);
    XrResult beginFrame();
    XrResult endFrame(XrTime time, const std::vector<const XrCompositionLayerBaseHeader*>& layers = {});
    // Runs a frame with these layers and returns the result of xrEndFrame. If that is an error, ends the
    // frame without layers, because a rejected xrEndFrame leaves it begun.
    XrResult tryFrame(const std::vector<const XrCompositionLayerBaseHeader*>& layers);
    // Runs a frame with a projection layer that shows a sub-image to each eye. Its views are the located
    // views, moved along x by `aside_m`. If xrLocateViews is refused, they start at the origin.
    void projectionFrame(const XrSwapchainSubImage& left, const XrSwapchainSubImage& right,
                         float aside_m = 0);
    // The same with the first two array layers of an image, which is first acquired and released.
    void projectionFrame(const Swapchain& swapchain, float aside_m = 0);

    XrResult tryLocateViews(XrSpace space, XrTime time, std::array<XrView, 2>& views);
    std::array<XrView, 2> locateViews(XrSpace space, XrTime time);  // left, right
    XrSpaceLocation locate(XrSpace space, XrSpace base, XrTime time, XrSpaceVelocity* velocity = nullptr);
    std::vector<std::int64_t> swapchainFormats();

    XrSwapchainCreateInfo swapchainInfo() const;
    Swapchain createSwapchain(const XrSwapchainCreateInfo& info);
    std::uint32_t acquireAndWait(XrSwapchain swapchain);
    void cycle(XrSwapchain swapchain);  // acquire, wait, release
    XrSpace createSpace(XrReferenceSpaceType type, XrPosef pose = kIdentity);
    XrPath path(const char* text);

    XrGraphicsBindingVulkan2KHR binding() const;
    XrResult trySession(const void* binding, XrSession* session);

    bool validated_ = true;                // with Vulkan's validation layer, if it is installed
    std::vector<std::string> extensions_;  // for tryInstance(); empty means all offered extensions
    XrInstance instance_ = XR_NULL_HANDLE;
    XrSystemId system_ = XR_NULL_SYSTEM_ID;
    XrSession session_ = XR_NULL_HANDLE;
    XrSpace stage_ = XR_NULL_HANDLE;
    VkInstance vk_instance_ = VK_NULL_HANDLE;
    VkPhysicalDevice vk_physical_device_ = VK_NULL_HANDLE;
    VkDevice vk_device_ = VK_NULL_HANDLE;
    VkQueue vk_queue_ = VK_NULL_HANDLE;
    std::uint32_t vk_queue_family_ = 0;
    std::vector<std::string> vk_messages_;

  private:
    VkDebugUtilsMessengerEXT vk_messenger_ = VK_NULL_HANDLE;
    stylet::test::TempFolder folder_;
    std::vector<std::string> variables_;
};

}  // namespace mock_test
