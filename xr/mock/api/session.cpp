#include <algorithm>
#include <memory>

#include "api/api.h"
#include "world/director.h"
#include "world/objects.h"
#include "world/verify.h"

namespace xrmock {

namespace {

SessionTarget currentTarget(const Session& session, std::int64_t now_ns) {
    const Scenario& scenario = session.instance.scenario;
    if (session.exit_requested) return SessionTarget::exiting;
    if (scenario.exit_after_frames && session.frames_submitted >= *scenario.exit_after_frames)
        return SessionTarget::exiting;
    return targetAt(scenario.session, session.instance.clock.scenarioSeconds(now_ns));
}

const XrGraphicsBindingVulkanKHR& checkBinding(const Instance& instance, const XrSessionCreateInfo& info) {
    const auto* binding =
        findInChain<XrGraphicsBindingVulkanKHR>(info.next, XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR);
    require(binding != nullptr && (instance.extensions.contains(XR_KHR_VULKAN_ENABLE_EXTENSION_NAME) ||
                                   instance.extensions.contains(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)),
            XR_ERROR_GRAPHICS_DEVICE_INVALID, "a Vulkan graphics binding is needed");
    require(findInChain<XrGraphicsBindingVulkanKHR>(binding->next, XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR) ==
                nullptr,
            XR_ERROR_GRAPHICS_DEVICE_INVALID, "a session has one graphics binding");
    require(instance.graphics_requirements_queried, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING,
            "xrGetVulkanGraphicsRequirements2KHR was not called");
    require(binding->device != VK_NULL_HANDLE, XR_ERROR_GRAPHICS_DEVICE_INVALID, "the VkDevice is null");
    return *binding;
}

const VulkanInstance& checkVulkanInstance(const Instance& instance,
                                          const XrGraphicsBindingVulkanKHR& binding) {
    for (const VulkanInstance& each : instance.vulkan_instances) {
        if (each.instance != binding.instance) continue;
        require(each.physical_device != VK_NULL_HANDLE && each.physical_device == binding.physicalDevice,
                XR_ERROR_GRAPHICS_DEVICE_INVALID, "not the device that xrGetVulkanGraphicsDevice2KHR named");
        const bool may_be_foreign = instance.extensions.contains(XR_KHR_VULKAN_ENABLE_EXTENSION_NAME);
        require(may_be_foreign ||
                    std::find(each.devices.begin(), each.devices.end(), binding.device) != each.devices.end(),
                XR_ERROR_GRAPHICS_DEVICE_INVALID, "the VkDevice was not made by xrCreateVulkanDeviceKHR");
        return each;
    }
    refuse(XR_ERROR_GRAPHICS_DEVICE_INVALID,
           "the VkInstance was neither made by xrCreateVulkanInstanceKHR nor given to "
           "xrGetVulkanGraphicsDeviceKHR");
}

}  // namespace

void enter(Session& session, XrSessionState state, std::int64_t now_ns) {
    session.progress.state = state;
    const auto handle = toHandle<XrSession>(session);
    session.instance.events.push(XrEventDataSessionStateChanged{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED,
                                                                nullptr, handle, state, now_ns});
    observeState(session, state);
    if (state != XR_SESSION_STATE_FOCUSED) stopAllPulses(session.haptics, now_ns);
    if (state == XR_SESSION_STATE_STOPPING) releaseInput(session.input);
}

void advance(Session& session, std::int64_t now_ns, bool frame_ended) {
    if (session.loss != Loss::none) return;
    bool may_rise = frame_ended;
    while (const auto next = nextState(session.progress, currentTarget(session, now_ns))) {
        if (isUpwardStep(session.progress.state, *next) &&
            currentTarget(session, now_ns) > SessionTarget::stopped) {
            if (!may_rise) return;
            may_rise = false;
        }
        enter(session, *next, now_ns);
    }
}

XrResult createSession(Call& call, XrInstance handle, const XrSessionCreateInfo* info, XrSession* out) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_SESSION_CREATE_INFO);
    requireValid(out != nullptr, "session is null");
    requireValid(info->createFlags == 0, "createFlags must be 0");
    requireSystem(info->systemId);
    const XrGraphicsBindingVulkanKHR& binding = checkBinding(instance, *info);
    const VulkanInstance& vulkan = checkVulkanInstance(instance, binding);
    require(findSession(instance) == nullptr, XR_ERROR_LIMIT_REACHED,
            "an instance has one session at a time");
    Session& session = call.create(std::make_unique<Session>(instance, vulkan, binding), &instance);
    advance(session, instance.clock.now(call.now_ns), false);
    *out = toHandle<XrSession>(session);
    return XR_SUCCESS;
}

XrResult destroySession(Call& call, XrSession handle) {
    runtime().handles.destroy(call.liveOrLost<Session>(handle));
    runtime().changed.notify_all();
    return XR_SUCCESS;
}

XrResult beginSession(Call& call, XrSession handle, const XrSessionBeginInfo* info) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_SESSION_BEGIN_INFO);
    requireViewConfiguration(info->primaryViewConfigurationType);
    require(!session.progress.running, XR_ERROR_SESSION_RUNNING, "the session runs already");
    require(session.progress.state == XR_SESSION_STATE_READY, XR_ERROR_SESSION_NOT_READY,
            "the session is not READY");
    session.progress.running = true;
    session.progress.frame_ended = false;
    ++session.run;
    const std::int64_t last_display_ns = session.frames.last_display_ns;
    session.frames = {};
    session.frames.last_display_ns = last_display_ns;
    announcePresence(session);
    return XR_SUCCESS;
}

XrResult endSession(Call& call, XrSession handle) {
    Session& session = call.live<Session>(handle);
    require(session.progress.running, XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    require(session.progress.state == XR_SESSION_STATE_STOPPING, XR_ERROR_SESSION_NOT_STOPPING,
            "the session is not STOPPING");
    session.progress.running = false;
    runtime().changed.notify_all();
    advance(session, session.instance.clock.now(call.now_ns), false);
    return XR_SUCCESS;
}

XrResult requestExitSession(Call& call, XrSession handle) {
    Session& session = call.live<Session>(handle);
    require(session.progress.running, XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    session.exit_requested = true;
    advance(session, session.instance.clock.now(call.now_ns), false);
    return XR_SUCCESS;
}

}  // namespace xrmock
