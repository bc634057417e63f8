// A small OpenXR client over Vulkan, for tests that walk the mock runtime through the system's loader.
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

// Returns once the thread of that number, set by the thread itself, sleeps in a call; throws
// std::runtime_error when it does not within a minute.
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

// The runtime's own entry, past the loader (which trusts arguments more than a runtime may).
PFN_xrGetInstanceProcAddr runtimeEntry();

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};
constexpr auto kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;

// What the runtime and the loader offer together.
std::vector<std::string> offeredExtensions();

struct Swapchain {
    XrSwapchain handle = XR_NULL_HANDLE;
    std::vector<VkImage> images;
    std::uint32_t width = 0, height = 0;
};

// Each test has a fresh folder, an environment that it sets before start(), and at most one instance and
// session. At the end everything goes, and Vulkan must have nothing to complain about.
class MockTest : public testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;

    void setVariable(const std::string& name, const std::string& value);
    void setScript(const std::string& text);
    std::filesystem::path file(const std::string& name) const { return folder_ / name; }

    XrResult tryInstance(const void* next = nullptr);  // xrCreateInstance
    void start();                                      // instance and system
    void startVulkan();                                // and Vulkan instance, physical device, device, queue
    void destroyVulkanInstance();
    void startSession();  // and a session, with a STAGE space
    void startRunning();  // and xrBeginSession
    void startFocused();  // and frames until FOCUSED

    // The next event of the type that is waiting, skipping others.
    std::optional<XrEventDataBuffer> poll(XrStructureType type);
    // All session states that are waiting.
    std::vector<XrSessionState> states();
    // One frame with these layers; its predicted display time.
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

    bool validated_ = true;                // by Vulkan's validation layer, where there is one
    std::vector<std::string> extensions_;  // for tryInstance; empty: all that are offered
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
