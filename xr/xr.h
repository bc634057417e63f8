// OpenXR: instance, session, frames, input and layers. This module handles Vulkan handles and poses only;
// it knows nothing about patients or rendering. Call everything on the frame thread unless a comment says
// otherwise.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "base/errors.h"
#include "base/geometry.h"

namespace stylet::xr {

// An OpenXR call failed, or no runtime was found. what() is one sentence for the user.
class XrError : public EnvironmentError {
  public:
    using EnvironmentError::EnvironmentError;
};

// --- Session settings and runtime facts ---

// Options that the application requests. The session also starts if the runtime does not support them.
struct SessionSettings {
    bool passthrough = false;  // show the real room behind the image, through the environment blend mode
    // Prefer the stationary reference space, which the user cannot move, so that a device can be registered
    // in it. Its origin can be anywhere, at any height and with any heading.
    bool stationary = false;
    // Set this if the runtime's time advances once per frame and cannot be converted to CLOCK_MONOTONIC.
    bool virtual_clock = false;
};

struct RuntimeFacts {
    std::string runtime_name, runtime_version, system_name;
    std::vector<std::string> extensions;  // granted, in the order of the request
    // Known after start(). poll() updates the profiles and the refresh rate.
    // Active profile per hand (left, right): "/interaction_profiles/...", or "" for none.
    std::array<std::string, 2> profiles;
    std::string space;                    // "stationary", "stage", "local_floor", "local"
    std::string blend_mode;               // "opaque", "additive", "alpha_blend"
    double refresh_hz = 0;                // 0 until the runtime reports it or the first frame begins
    std::uint32_t width = 0, height = 0;  // recommended size per eye [px]
};

// Files in which the OpenXR loader looks for the active runtime, in order. Used by error messages and
// `stylet doctor`.
std::vector<std::string> runtimeSearchPath();

// --- A frame ---

struct EyeView {
    Pose stage_from_eye;
    float angle_left = 0, angle_right = 0, angle_up = 0, angle_down = 0;
};

struct Frame {
    std::int64_t predicted_display_time_ns = 0;    // in the runtime's time
    std::int64_t predicted_display_period_ns = 0;  // 0 if the runtime does not report it
    bool should_render = false;
    std::array<EyeView, 2> views;
    // Two array layers, one per eye. Valid between beginFrame and endFrame if should_render is set. The
    // layouts are COLOR_ATTACHMENT_OPTIMAL and DEPTH_STENCIL_ATTACHMENT_OPTIMAL, both on acquire and on
    // release.
    VkImage image = VK_NULL_HANDLE;
    VkImage depth_image = VK_NULL_HANDLE;  // D32_SFLOAT; write all of it. Null: no depth image in this frame.
};

// A flat image in the room, visible only from its front (+z). Its alpha is straight, not premultiplied.
struct ShownPanel {
    int id = 0;             // as returned by addPanel()
    Pose stage_from_panel;  // pose of the panel's centre; if head-locked, in the head's frame (-z forward)
    double width_m = 0, height_m = 0;
    bool head_locked = false;
    // Composited under the projection layer. It shows through where the projection layer's alpha is 0,
    // whatever the colour there.
    bool behind = false;
};

// --- User input ---

// State of one hand at the last beginFrame. A bare hand is tracked without a controller. Its pinches replace
// the buttons.
struct Hand {
    bool active = false;  // a controller or a bare hand is tracked and the session has input focus
    bool bare = false;
    std::optional<Pose> stage_from_grip;
    // Points along -z. Bare hand: the origin is between the tips of thumb and index finger.
    std::optional<Pose> stage_from_aim;
    bool select = false;                    // trigger; bare hand: thumb and index finger pinch
    bool menu = false;                      // menu button; bare hand: thumb and middle finger pinch
    float squeeze = 0;                      // [0, 1]; bare hand: 1 while thumb and ring finger pinch
    std::array<float, 2> thumbstick{0, 0};  // thumbstick or trackpad; right and up in [-1, 1]
};

// --- Session events ---

enum class SessionPhase { idle, ready, synchronized, visible, focused, stopping, lossPending, exiting };

// The origin of the stage frame moves. From `at_ns` on (runtime time, as in Frame), poses are relative to
// the new origin.
struct SpaceChange {
    std::int64_t at_ns = 0;
    bool pose_valid = false;  // false: the transform between old and new origin is unknown
    Pose previous_from_new;
};

// Events since the last call of popEvents(), in order. poll() collects them.
struct SessionEvents {
    std::vector<SpaceChange> spaces;
    std::array<bool, 2> hidden_area_changed{};
    bool profiles_changed = false;
    // Latest report of whether the headset is worn (XR_EXT_user_presence); nullopt if there was none.
    std::optional<bool> worn;
};

// The part of an eye's image that the lens hides: triangles that need not be drawn. The vertices are
// tangents of view angles (right, up).
struct HiddenArea {
    std::vector<std::array<float, 2>> tangents;
    std::vector<std::uint32_t> indices;  // three per triangle
};

// The OpenXR instance, session and swapchains. Call the Vulkan functions between construction and start().
// A lost session (SessionPhase::lossPending) cannot recover: create a new Session. While the runtime is
// unavailable, the constructor throws XrError.
class Session {
  public:
    explicit Session(const std::string& application_name, const SessionSettings& = {});  // throws XrError
    // Requests exit if the session is running. Returns after about 1 s at most, even if the runtime hangs.
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    const std::string& runtimeName() const;
    const RuntimeFacts& facts() const;
    // One sentence for each non-fatal refusal by the runtime, such as a controller's bindings or a
    // floor-level space.
    const std::vector<std::string>& notes() const;

    // Create the caller's Vulkan instance and device through XR_KHR_vulkan_enable2.
    VkResult createVulkanInstance(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*);
    VkPhysicalDevice vulkanPhysicalDevice(VkInstance);
    VkResult createVulkanDevice(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*,
                                VkDevice*);

    // Creates the session, spaces, actions and one two-layer sRGB colour swapchain. Throws XrError.
    void start(VkInstance, VkPhysicalDevice, VkDevice, std::uint32_t queue_family);
    // Keeps `device` alive until the session is destroyed. If the runtime hangs, that can be after
    // ~Session() returns. The session's images belong to this device.
    void keepAlive(std::shared_ptr<void> device);
    VkFormat colourFormat() const;
    std::uint32_t width() const;
    std::uint32_t height() const;

    // Polls events and runs the state machine. Begins and ends the session when the runtime requests it.
    SessionPhase poll();
    SessionEvents popEvents();
    // True from READY to STOPPING. Only then may frames be rendered.
    bool running() const;

    // Waits for the next frame, locates the views at its predicted display time and, if it should be
    // rendered, acquires the images. Returns an empty frame if the session is lost; poll() then reports the
    // loss.
    Frame beginFrame();
    // Locates the views again for the frame's display time. Call it as late as possible before rendering:
    // endFrame submits the views located last. Returns false and leaves the frame unchanged if the views
    // cannot be located.
    bool lateUpdate(Frame&);
    // Submits the image and the panels. The panels keep the given order. Submits no layers if the frame was
    // not rendered.
    void endFrame(const Frame&, std::span<const ShownPanel> = {});
    // Clip planes of the depth images. Depth is reversed: 1 at near, 0 at far; far may be infinite. Call
    // after start(). From then on frames have a depth image if the runtime supports depth layers.
    void setDepthRange(float near_m, float far_m);
    // Empty without XR_KHR_visibility_mask, and if the lens hides nothing. Call after start().
    HiddenArea hiddenArea(int eye) const;

    // Creates an 8-bit sRGB image (panelFormat) for a ShownPanel and returns its id. If the runtime
    // refuses, returns -1 and adds a note; acquirePanel() then returns null, and endFrame() skips the
    // panel. Call after start().
    int addPanel(std::uint32_t width, std::uint32_t height);
    VkFormat panelFormat() const;
    // Write the whole image. Its layout is COLOR_ATTACHMENT_OPTIMAL before and after. Null if no image is
    // free.
    VkImage acquirePanel(int id);
    void releasePanel(int id);

    Hand hand(int side) const;  // 0 left, 1 right; state at the last frame
    // Any thread, during the session's lifetime. Never throws. Returns nullopt if the hand is not tracked,
    // or if the session is lost or has no focus. `when_ns` is in CLOCK_MONOTONIC. If it cannot be converted
    // to the runtime's time, the pose at the last frame's display time is returned.
    std::optional<Pose> gripAt(int side, std::int64_t when_ns) const;
    // Any thread. Converts a runtime time to CLOCK_MONOTONIC. Returns nullopt without
    // XR_KHR_convert_timespec_time and on a virtual clock.
    std::optional<std::int64_t> monotonic_ns(std::int64_t runtime_ns) const;
    // Generation id of the stationary space, or "" for other spaces. The space's origin is unchanged while
    // the id is unchanged. A registration stores it.
    std::string spaceGeneration() const;
    // Vibrates the controller; amplitude in [0, 1].
    void pulse(int side, float amplitude, std::int64_t duration_ns);

    // Asks the runtime to end the session. It answers with STOPPING: keep polling until `exiting`.
    void requestExit();
    // Inserts a label into the runtime's debug stream, if XR_EXT_debug_utils is available. The mock runtime
    // captures the next submitted frame under this name.
    void markCapture(const std::string& label);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::xr
