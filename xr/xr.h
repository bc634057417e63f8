// OpenXR: instance, session, frames. Knows nothing of patients or pictures: Vulkan handles and poses only.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

namespace stylet::xr {

// An OpenXR call failed, or no runtime could be reached: one sentence for the user.
class XrError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

struct Pose {                                       // stage frame, metres
    std::array<double, 4> orientation{0, 0, 0, 1};  // x y z w
    std::array<double, 3> position{0, 0, 0};
};
struct EyeView {
    Pose stage_from_eye;
    float angle_left = 0, angle_right = 0, angle_up = 0, angle_down = 0;
};

struct Frame {
    std::int64_t predicted_display_time_ns = 0;
    bool should_render = false;
    std::array<EyeView, 2> views;
    VkImage image = VK_NULL_HANDLE;  // two layers; valid between beginFrame and endFrame when should_render
};

enum class SessionPhase { idle, ready, synchronized, visible, focused, stopping, lossPending, exiting };

// The controllers as the trainer reads them (simple controller profile).
struct Hand {
    bool active = false;
    std::optional<Pose> stage_from_grip;
    bool select = false, menu = false;
};

// Where a runtime would be looked for, for messages and `stylet doctor`.
std::vector<std::string> runtimeSearchPath();

// Everything from xrCreateInstance to the swapchain. The Vulkan hooks are valid between construction and
// start().
class Session {
  public:
    explicit Session(const std::string& application_name);  // throws XrError
    // Asks a running session to end and gives the runtime at most a second for it.
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    const std::string& runtimeName() const;
    // What the runtime refused without harm (a controller's bindings, a floor-level space), a sentence each.
    const std::vector<std::string>& notes() const;

    // For the caller's Vulkan device (XR_KHR_vulkan_enable2).
    VkResult createVulkanInstance(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*);
    VkPhysicalDevice vulkanPhysicalDevice(VkInstance);
    VkResult createVulkanDevice(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*,
                                VkDevice*);

    // Creates the session, spaces, actions and one two-layer sRGB colour swapchain.
    void start(VkInstance, VkPhysicalDevice, VkDevice, std::uint32_t queue_family);
    VkFormat colourFormat() const;
    std::uint32_t width() const;
    std::uint32_t height() const;

    // Polls events and runs the state machine; begins and ends the session as the runtime asks.
    SessionPhase poll();
    // True from READY to STOPPING: frames may be made.
    bool running() const;
    // Waits for the next frame, locates the views and, when it should be drawn, acquires the image. The views
    // are those of the frame's predicted display time. With the session lost: an empty frame, and poll() says
    // so.
    Frame beginFrame();
    // Submits both layers of the image, or nothing when it was not to be drawn.
    void endFrame(const Frame&);
    Hand hand(int side) const;  // 0 left, 1 right; of the last frame
    // A vibration of the controller; amplitude in [0, 1].
    void pulse(int side, float amplitude, std::int64_t duration_ns);
    // The runtime answers with STOPPING: keep polling until `exiting`.
    void requestExit();
    // A label that stands in the runtime's debug stream (XR_EXT_debug_utils where offered): the mock runtime
    // captures the next submitted frame under this name.
    void markMoment(const std::string& label);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::xr
