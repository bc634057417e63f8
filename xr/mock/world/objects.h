// The objects behind the handles.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compositor/compositor.h"
#include "compositor/vulkan_device.h"
#include "control/control.h"
#include "scenario/conditions.h"
#include "scenario/frame_loop.h"
#include "scenario/pose.h"
#include "scenario/scenario.h"
#include "world/control_requests.h"
#include "world/events.h"
#include "world/faults.h"
#include "world/handles.h"
#include "world/haptics.h"
#include "world/input.h"
#include "world/observers.h"
#include "world/paths.h"
#include "world/session_state.h"

namespace xrmock {

constexpr XrSystemId kSystemId = 1;

struct Listener {
    std::uint64_t messenger = 0;  // 0: the messenger chained to xrCreateInstance
    XrDebugUtilsMessageSeverityFlagsEXT severities;
    XrDebugUtilsMessageTypeFlagsEXT types;
    PFN_xrDebugUtilsMessengerCallbackEXT callback;
    void* user_data;
};

struct Statistics {
    std::uint64_t submitted = 0, discarded = 0, missed = 0, captured = 0, haptic_pulses = 0, refusals = 0;
};

struct Instance : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_INSTANCE;
    Instance();
    ~Instance() override;

    std::set<std::string, std::less<>> extensions;
    Scenario scenario;
    Conditions conditions;
    std::vector<Fault> faults;
    std::vector<Stall> stalls;
    std::unique_ptr<Control> control;  // null without XRMOCK_CONTROL
    Lockstep lockstep;
    std::vector<PendingReply> pending_replies;
    Clock clock;
    std::int64_t created_ns = 0;  // CLOCK_MONOTONIC
    std::string capture_folder;   // empty: captures are off
    bool capture_failed = false;  // a failed capture was reported
    EventQueue events;
    PathTable paths;
    // By interaction profile path.
    std::map<std::string, std::vector<SuggestedBinding>, std::less<>> suggestions;
    std::vector<Listener> listeners;
    bool graphics_requirements_queried = false;
    std::vector<VulkanInstance> vulkan_instances;
    Statistics statistics;
    std::string first_refusal;
    std::string application;  // the application's name
};

struct Messenger : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_DEBUG_UTILS_MESSENGER_EXT;
    explicit Messenger(Instance& owner) : Object(kType), instance(owner) {}
    ~Messenger() override {
        std::erase_if(instance.listeners, [&](const Listener& l) { return l.messenger == handle; });
    }
    Instance& instance;
};

struct Label {
    std::string name;
    bool region;  // a region lasts until it is ended; other labels until the next label
};

struct Session : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_SESSION;
    Session(Instance& owner, const VulkanInstance& vulkan, const XrGraphicsBindingVulkanKHR& binding)
        : Object(kType), instance(owner), device(vulkan, binding) {}
    ~Session() override { instance.events.dropEvents(toHandle<XrSession>(*this)); }

    Instance& instance;
    VulkanDevice device;
    Compositor compositor;
    SessionProgress progress;
    std::uint64_t run = 0;  // number of xrBeginSession calls; a waiting call belongs to one run
    Loss loss = Loss::none;
    std::optional<std::int64_t> lost_at_ns;  // when the pending loss takes effect
    bool exit_requested = false;
    std::uint64_t frames_submitted = 0;
    FrameLoop frames;
    Automation automation;
    InputState input;
    Haptics haptics;
    std::uint64_t pulses_seen = 0;  // pulses already checked by the assertions
    std::vector<Label> labels;
    std::string capture_name;  // empty: do not capture the next frame
};

struct ActionSet : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_ACTION_SET;
    explicit ActionSet(Instance& owner) : Object(kType), instance(owner) {}
    Instance& instance;
    std::string name, localized_name;
    std::uint32_t priority = 0;
    bool attached = false;  // was attached to a session and is therefore immutable
};

struct Action : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_ACTION;
    explicit Action(ActionSet& owner) : Object(kType), set(owner) {}
    ActionSet& set;
    std::string name, localized_name;
    XrActionType action_type = XR_ACTION_TYPE_BOOLEAN_INPUT;
    std::vector<XrPath> subaction_paths;
};

struct Space : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_SPACE;
    explicit Space(Session& owner) : Object(kType), session(owner) {}
    Session& session;
    Pose origin_from_space;
    XrReferenceSpaceType reference = XR_REFERENCE_SPACE_TYPE_MAX_ENUM;  // MAX_ENUM: an action space
    std::uint64_t action = 0;
    XrPath subaction_path = XR_NULL_PATH;
};

struct HandTracker : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_HAND_TRACKER_EXT;
    HandTracker(Session& owner, bool left) : Object(kType), session(owner), is_left(left) {}
    Session& session;
    bool is_left;
};

struct Swapchain : Object {
    static constexpr XrObjectType kType = XR_OBJECT_TYPE_SWAPCHAIN;
    Swapchain(Session& owner, const XrSwapchainCreateInfo& info, std::uint32_t count)
        : Object(kType), session(owner), images(owner.device, info, count) {}

    Session& session;
    SwapchainImages images;
    bool is_static = false;
    std::deque<std::uint32_t> free_images;
    std::deque<std::uint32_t> acquired;  // oldest first
    bool oldest_waited = false;
    std::optional<std::uint32_t> last_released;
};

// The session of an instance, or null: an instance has at most one.
inline Session* findSession(const Instance& instance) {
    for (Object* child : instance.children)
        if (child->type == Session::kType) return static_cast<Session*>(child);
    return nullptr;
}

inline Sources makeSources(const Session& session) {
    return {session.instance.scenario, session.automation, session.instance.clock};
}

// Enters the state and sends the state-changed event.
void enter(Session& session, XrSessionState state, std::int64_t now_ns);

// Advances the session state towards its target. An upward step (isUpwardStep) is made only at the end of a
// frame, and at most one.
void advance(Session& session, std::int64_t now_ns, bool frame_ended);

}  // namespace xrmock
