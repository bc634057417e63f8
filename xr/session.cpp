#include <algorithm>
#include <cassert>
#include <chrono>
#include <thread>

#include "xr/input.h"
#include "xr/instance.h"
#include "xr/state_machine.h"
#include "xr/swapchain.h"

namespace stylet::xr {
namespace {

// Where LOCAL's origin is taken to be above the floor when the runtime knows no floor: a standing adult's
// eyes.
constexpr float kAssumedEyeHeight_m = 1.6f;
constexpr auto kExitPatience = std::chrono::seconds(1);

XrEnvironmentBlendMode chooseBlendMode(XrInstance instance, XrSystemId system) {
    const char* call = "xrEnumerateEnvironmentBlendModes";
    const auto kind = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    const char* meaning = "the headset does not show one picture for each of two eyes";
    std::uint32_t count = 0;
    check(xrEnumerateEnvironmentBlendModes(instance, system, kind, 0, &count, nullptr), call, meaning);
    std::vector<XrEnvironmentBlendMode> modes(count);
    check(xrEnumerateEnvironmentBlendModes(instance, system, kind, count, &count, modes.data()), call,
          meaning);
    if (std::find(modes.begin(), modes.end(), XR_ENVIRONMENT_BLEND_MODE_OPAQUE) != modes.end())
        return XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    return modes.at(0);  // the runtime's own preference comes first
}

}  // namespace

struct Session::Impl {
    explicit Impl(const std::string& application_name) : instance(application_name) {}

    // True on success. A lost session is a state, not an error; anything else that fails throws.
    bool usable(XrResult result, const char* call, const char* meaning) {
        if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST ||
            result == XR_SESSION_LOSS_PENDING)
            machine.onLoss();
        else
            check(result, call, meaning);
        return !machine.over();
    }
    void createStage();
    void onStateChanged(XrSessionState);
    bool locateViews(Frame&);

    // Declaration order is teardown order, reversed.
    Instance instance;
    std::vector<std::string> notes;
    Owned<XrSession, xrDestroySession> session;
    Owned<XrSpace, xrDestroySpace> stage;
    Input input;
    Swapchain swapchain;
    StateMachine machine;
    XrEnvironmentBlendMode blend_mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    // As the runtime gave them: what is submitted must equal them to the bit.
    std::array<XrView, 2> views{};
    bool frame_begun = false;
};

Session::Session(const std::string& application_name) : impl_(std::make_unique<Impl>(application_name)) {}

Session::~Session() {
    if (!impl_->machine.running) return;
    try {
        requestExit();
        const auto deadline = std::chrono::steady_clock::now() + kExitPatience;
        while (poll() != SessionPhase::exiting && !impl_->machine.over() &&
               std::chrono::steady_clock::now() < deadline)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } catch (const XrError&) {
        // The session is destroyed next, which is allowed in every state.
    }
}

const std::string& Session::runtimeName() const {
    return impl_->instance.runtime_name;
}
const std::vector<std::string>& Session::notes() const {
    return impl_->notes;
}

VkResult Session::createVulkanInstance(PFN_vkGetInstanceProcAddr loader, const VkInstanceCreateInfo* info,
                                       VkInstance* out) {
    return impl_->instance.createVulkanInstance(loader, info, out);
}

VkPhysicalDevice Session::vulkanPhysicalDevice(VkInstance vulkan) {
    return impl_->instance.vulkanPhysicalDevice(vulkan);
}

VkResult Session::createVulkanDevice(PFN_vkGetInstanceProcAddr loader, VkPhysicalDevice gpu,
                                     const VkDeviceCreateInfo* info, VkDevice* out) {
    return impl_->instance.createVulkanDevice(loader, gpu, info, out);
}

void Session::start(VkInstance vulkan, VkPhysicalDevice gpu, VkDevice device, std::uint32_t queue_family) {
    Impl& s = *impl_;
    auto binding = typed<XrGraphicsBindingVulkan2KHR>(XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
    binding.instance = vulkan;
    binding.physicalDevice = gpu;
    binding.device = device;
    binding.queueFamilyIndex = queue_family;
    auto info = typed<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
    info.next = &binding;
    info.systemId = s.instance.system;
    check(xrCreateSession(s.instance.handle.get(), &info, s.session.out()), "xrCreateSession",
          "the runtime \"" + s.instance.runtime_name + "\" does not let this program show anything now");
    s.blend_mode = chooseBlendMode(s.instance.handle.get(), s.instance.system);
    s.createStage();
    s.input.create(s.instance.handle.get(), s.session.get(), s.notes);
    s.swapchain.create(s.instance.handle.get(), s.instance.system, s.session.get());
}

void Session::Impl::createStage() {
    const char* call = "xrEnumerateReferenceSpaces";
    std::uint32_t count = 0;
    check(xrEnumerateReferenceSpaces(session.get(), 0, &count, nullptr), call, "the runtime tracks no space");
    std::vector<XrReferenceSpaceType> spaces(count);
    check(xrEnumerateReferenceSpaces(session.get(), count, &count, spaces.data()), call,
          "the runtime tracks no space");

    auto info = typed<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    info.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE;
    info.poseInReferenceSpace = kIdentityPose;
    if (std::find(spaces.begin(), spaces.end(), XR_REFERENCE_SPACE_TYPE_STAGE) == spaces.end()) {
        info.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
        info.poseInReferenceSpace.position.y = -kAssumedEyeHeight_m;
        notes.push_back(
            "xrEnumerateReferenceSpaces: the runtime knows no floor: it is taken to be 1.6 m below the head");
    }
    check(xrCreateReferenceSpace(session.get(), &info, stage.out()), "xrCreateReferenceSpace",
          "the runtime tracks no space");
}

VkFormat Session::colourFormat() const {
    return impl_->swapchain.format();
}
std::uint32_t Session::width() const {
    return impl_->swapchain.width();
}
std::uint32_t Session::height() const {
    return impl_->swapchain.height();
}

SessionPhase Session::poll() {
    Impl& s = *impl_;
    for (;;) {
        XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
        const XrResult result = xrPollEvent(s.instance.handle.get(), &event);
        if (result == XR_EVENT_UNAVAILABLE) break;
        if (!s.usable(result, "xrPollEvent", "the runtime has stopped answering")) break;
        if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
            s.onStateChanged(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state);
        else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
            s.machine.onLoss();
    }
    return s.machine.phase;
}

void Session::Impl::onStateChanged(XrSessionState state) {
    switch (machine.onState(state)) {
        case SessionAct::begin: {
            auto info = typed<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
            info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
            usable(xrBeginSession(session.get(), &info), "xrBeginSession",
                   "the runtime announced READY, then refused");
            break;
        }
        case SessionAct::end:
            usable(xrEndSession(session.get()), "xrEndSession",
                   "the runtime announced STOPPING, then refused");
            break;
        case SessionAct::none:
            break;
    }
}

bool Session::running() const {
    return impl_->machine.running;
}

Frame Session::beginFrame() {
    Impl& s = *impl_;
    assert(s.machine.running && !s.frame_begun);
    Frame frame;
    const char* meaning = "the runtime refuses the next frame";
    const XrFrameWaitInfo wait{XR_TYPE_FRAME_WAIT_INFO, nullptr};
    auto state = typed<XrFrameState>(XR_TYPE_FRAME_STATE);
    if (!s.usable(xrWaitFrame(s.session.get(), &wait, &state), "xrWaitFrame", meaning)) return frame;
    frame.predicted_display_time_ns = state.predictedDisplayTime;
    if (!s.usable(s.input.sync(s.session.get(), s.stage.get(), state.predictedDisplayTime), "xrSyncActions",
                  "the controllers cannot be read"))
        return frame;
    // XR_FRAME_DISCARDED, a success, says that the frame before was dropped; this one has begun all the same.
    const XrFrameBeginInfo begin{XR_TYPE_FRAME_BEGIN_INFO, nullptr};
    if (!s.usable(xrBeginFrame(s.session.get(), &begin), "xrBeginFrame", meaning)) return frame;
    s.frame_begun = true;

    if (!s.locateViews(frame) || !state.shouldRender) return frame;
    if (!s.usable(s.swapchain.acquire(frame.should_render), "xrAcquireSwapchainImage",
                  "no image to draw into"))
        frame.should_render = false;
    if (frame.should_render) frame.image = s.swapchain.image();
    return frame;
}

bool Session::Impl::locateViews(Frame& frame) {
    auto info = typed<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
    info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    info.displayTime = frame.predicted_display_time_ns;
    info.space = stage.get();
    auto state = typed<XrViewState>(XR_TYPE_VIEW_STATE);
    views.fill({XR_TYPE_VIEW, nullptr, kIdentityPose, {}});
    std::uint32_t count = 0;
    if (!usable(xrLocateViews(session.get(), &info, &state, 2, &count, views.data()), "xrLocateViews",
                "the runtime does not say where the eyes are"))
        return false;
    constexpr XrViewStateFlags kWhole =
        XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    if ((state.viewStateFlags & kWhole) != kWhole || count != 2) return false;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const XrFovf& fov = views[eye].fov;
        frame.views[eye] = {poseOf(views[eye].pose), fov.angleLeft, fov.angleRight, fov.angleUp,
                            fov.angleDown};
    }
    return true;
}

void Session::endFrame(const Frame& frame) {
    Impl& s = *impl_;
    if (!s.frame_begun) return;  // the session was lost while the frame began
    s.frame_begun = false;
    const bool drawn = s.swapchain.held();
    if (drawn &&
        !s.usable(s.swapchain.release(), "xrReleaseSwapchainImage", "the picture cannot be handed over"))
        return;

    std::array<XrCompositionLayerProjectionView, 2> eyes{};
    for (std::uint32_t eye = 0; eye < 2; ++eye)
        eyes[eye] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, s.views[eye].pose, s.views[eye].fov,
                     s.swapchain.subImage(eye)};
    auto layer = typed<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
    layer.space = s.stage.get();
    layer.viewCount = 2;
    layer.views = eyes.data();
    const auto* base = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
    auto end = typed<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
    end.displayTime = frame.predicted_display_time_ns;
    end.environmentBlendMode = s.blend_mode;
    end.layerCount = drawn ? 1 : 0;
    end.layers = drawn ? &base : nullptr;
    s.usable(xrEndFrame(s.session.get(), &end), "xrEndFrame", "the runtime refuses the picture");
}

Hand Session::hand(int side) const {
    return impl_->input.hand(side);
}

void Session::pulse(int side, float amplitude, std::int64_t duration_ns) {
    impl_->usable(impl_->input.pulse(impl_->session.get(), side, amplitude, duration_ns),
                  "xrApplyHapticFeedback", "the controller does not vibrate");
}

void Session::requestExit() {
    const XrResult result = xrRequestExitSession(impl_->session.get());
    if (result != XR_ERROR_SESSION_NOT_RUNNING)
        impl_->usable(result, "xrRequestExitSession", "the runtime does not end the session");
}

void Session::markMoment(const std::string& label) {
    Impl& s = *impl_;
    if (!s.instance.insertLabel) return;
    const std::string name = "capture:" + label;
    const XrDebugUtilsLabelEXT info{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name.c_str()};
    s.usable(s.instance.insertLabel(s.session.get(), &info), "xrSessionInsertDebugUtilsLabelEXT",
             "the runtime takes no label");
}

}  // namespace stylet::xr
