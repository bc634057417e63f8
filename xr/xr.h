// OpenXR: instance, session, frames, input, layers. Knows nothing of patients or pictures: Vulkan handles and
// poses only. Frame thread, where nothing else is said.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
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

// --- What is asked for, and what was got ---

// Asked for, never required.
struct SessionSettings {
    bool passthrough = false;  // the room behind what is drawn, by the environment's blend mode
    // The space that nothing moves, where there is one: a device is registered in it. Its origin lies
    // anywhere, at any height and turned anyhow.
    bool stationary = false;
    bool virtual_clock = false;  // the runtime's time is its frame count: no time of it is one of ours
};

struct RuntimeFacts {
    std::string runtime_name, runtime_version, system_name;
    std::vector<std::string> extensions;  // granted, in the order asked for
    // Known after start(); those of the user change with poll().
    std::array<std::string, 2> profiles;  // bound, left and right: "/interaction_profiles/..."; "" for none
    std::string space;                    // "stationary", "stage", "local_floor", "local"
    std::string blend_mode;               // "opaque", "additive", "alpha_blend"
    double refresh_hz = 0;                // 0 until the runtime says so, or the first frame
    std::uint32_t width = 0, height = 0;  // of an eye, as recommended
};

// Where a runtime would be looked for, for messages and `stylet doctor`.
std::vector<std::string> runtimeSearchPath();

// --- A frame ---

struct EyeView {
    Pose stage_from_eye;
    float angle_left = 0, angle_right = 0, angle_up = 0, angle_down = 0;
};

struct Frame {
    std::int64_t predicted_display_time_ns = 0;    // the runtime's time
    std::int64_t predicted_display_period_ns = 0;  // until the next; 0 where the runtime does not say
    bool should_render = false;
    std::array<EyeView, 2> views;
    // Two layers each, an eye a layer; valid between beginFrame and endFrame when should_render. In
    // COLOR_ATTACHMENT_OPTIMAL and DEPTH_STENCIL_ATTACHMENT_OPTIMAL before and after.
    VkImage image = VK_NULL_HANDLE;
    VkImage depth_image = VK_NULL_HANDLE;  // D32_SFLOAT, to be written whole; null: none is wanted now
};

// A flat picture in the room. Seen from its front (+z) only; its alpha is straight, not premultiplied.
struct ShownPanel {
    int id = 0;             // of addPanel()
    Pose stage_from_panel;  // of its middle; head-locked: in the head's frame, -z forward
    double width_m = 0, height_m = 0;
    bool head_locked = false;
    // Under the projection layer, seen where that has alpha 0, whatever its colour there is.
    bool behind = false;
};

// --- What the user does ---

// One hand as the trainer reads it, as of the last beginFrame.
struct Hand {
    bool active = false;  // something is held or the bare hand is seen, and the session has the focus
    bool bare = false;    // a tracked hand without a controller
    std::optional<Pose> stage_from_grip;
    std::optional<Pose> stage_from_aim;     // -z points; of a bare hand: between thumb and index finger
    bool select = false;                    // trigger; of a bare hand thumb and index finger
    bool menu = false;                      // thumb and middle finger
    float squeeze = 0;                      // [0, 1]; thumb and ring finger
    std::array<float, 2> thumbstick{0, 0};  // right, up in [-1, 1]; or of a trackpad
};

// --- What happened ---

enum class SessionPhase { idle, ready, synchronized, visible, focused, stopping, lossPending, exiting };

// The stage frame moves: from `at_ns` on (the runtime's time, as of frames) poses mean other places.
struct SpaceChange {
    std::int64_t at_ns = 0;
    bool pose_valid = false;  // false: nobody knows how old and new lie to one another
    Pose previous_from_new;
};

// What happened since the last call of takeNews(), in order; poll() collects.
struct News {
    std::vector<SpaceChange> spaces;
    std::array<bool, 2> hidden_area_changed{};
    bool profiles_changed = false;
    std::optional<bool> worn;  // XR_EXT_user_presence: the headset was put on or taken off; the last word
};

// What the lens hides of an eye: triangles in tangents of view angles (right, up), to be left undrawn.
struct HiddenArea {
    std::vector<std::array<float, 2>> tangents;
    std::vector<std::uint32_t> indices;  // three a triangle
};

// Everything from xrCreateInstance to the swapchains. The Vulkan hooks are valid between construction and
// start(). After a loss (SessionPhase::lossPending) only a new Session helps; making one fails with XrError
// while the runtime is away.
class Session {
  public:
    explicit Session(const std::string& application_name, const SessionSettings& = {});  // throws XrError
    // Asks a running session to end. Takes about a second at most, whatever the runtime does.
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    const std::string& runtimeName() const;
    const RuntimeFacts& facts() const;
    // What the runtime refused without harm (a controller's bindings, a floor-level space), a sentence each.
    const std::vector<std::string>& notes() const;

    // For the caller's Vulkan device (XR_KHR_vulkan_enable2).
    VkResult createVulkanInstance(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*);
    VkPhysicalDevice vulkanPhysicalDevice(VkInstance);
    VkResult createVulkanDevice(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*,
                                VkDevice*);

    // Creates the session, spaces, actions and one two-layer sRGB colour swapchain. Throws XrError.
    void start(VkInstance, VkPhysicalDevice, VkDevice, std::uint32_t queue_family);
    // Held until the session is gone, which may be after the destructor has given up waiting for a runtime
    // that hangs: what the session's images belong to.
    void keep(std::shared_ptr<void> device);
    VkFormat colourFormat() const;
    std::uint32_t width() const;
    std::uint32_t height() const;

    // Polls events and runs the state machine; begins and ends the session as the runtime asks.
    SessionPhase poll();
    News takeNews();
    // True from READY to STOPPING: frames may be made.
    bool running() const;

    // Waits for the next frame, locates the views and, when it should be drawn, acquires the images. The
    // views are those of the frame's predicted display time. With the session lost: an empty frame, and
    // poll() says so.
    Frame beginFrame();
    // Locates the views once more for the frame's display time, as late as possible before they are drawn:
    // the submitted views are the ones located last. False and unchanged where they cannot be located.
    bool lateUpdate(Frame&);
    // Submits the image and the panels, in order, or nothing when it was not to be drawn.
    void endFrame(const Frame&, std::span<const ShownPanel> = {});
    // The planes of what is drawn into depth images: reversed, near at 1, far (may be infinite) at 0. From
    // now on frames have a depth image where the runtime takes one. After start().
    void setDepthRange(float near_m, float far_m);
    // Empty without XR_KHR_visibility_mask, and where a lens hides nothing. After start().
    HiddenArea hiddenArea(int eye) const;

    // An sRGB image of 8 bits (panelFormat) for a ShownPanel; -1 and a note where the runtime gives none:
    // such a panel is never acquired and never shown. After start().
    int addPanel(std::uint32_t width, std::uint32_t height);
    VkFormat panelFormat() const;
    // To be written whole; COLOR_ATTACHMENT_OPTIMAL before and after. Null: none is free now.
    VkImage acquirePanel(int id);
    void releasePanel(int id);

    Hand hand(int side) const;  // 0 left, 1 right; of the last frame
    // Any thread, while the session lives; never throws. Nothing while the hand is not tracked or the session
    // is lost or without focus. `when_ns` is of CLOCK_MONOTONIC; where the runtime's time cannot be had from
    // it, the pose is that of the last frame's display time.
    std::optional<Pose> gripAt(int side, std::int64_t when_ns) const;
    // Any thread. CLOCK_MONOTONIC of a time of the runtime; nothing without XR_KHR_convert_timespec_time and
    // on a virtual clock.
    std::optional<std::int64_t> monotonic_ns(std::int64_t runtime_ns) const;
    // Of a stationary space, else "": the space is the same as long as this is. Stored with a registration.
    std::string spaceGeneration() const;
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
