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
Struct structOf(XrStructureType type) {
    Struct result{};
    result.type = type;
    return result;
}

// The runtime's own entry point. It bypasses the loader, which checks its arguments less than a runtime
// must.
PFN_xrGetInstanceProcAddr runtimeEntry();

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};
constexpr auto kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;

// The extensions that the runtime and the loader offer together.
std::vector<std::string> offeredExtensions();

struct Swapchain {
    XrSwapchain handle = XR_NULL_HANDLE;
    std::vector<VkImage> images;
    std::uint32_t width = 0, height = 0;
};

// Each test has an empty folder, an environment that it sets before start(), and at most one instance and
// session. TearDown destroys everything, and Vulkan must not have reported any message.
class MockTest : public testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;

    void setVariable(const std::string& name, const std::string& value);
    void setScript(const std::string& text);
    std::filesystem::path file(const std::string& name) const { return folder_ / name; }

    XrResult tryInstance(const void* next = nullptr);  // xrCreateInstance
    void start();                                      // creates instance and system
    void startVulkan();                                // also Vulkan instance, device and queue
    void destroyVulkanInstance();
    void startSession();  // also a session with a STAGE space
    void startRunning();  // also calls xrBeginSession
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

    std::array<XrView, 2> locateViews(XrSpace space, XrTime time);  // left, right

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
