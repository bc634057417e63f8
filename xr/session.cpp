#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <thread>

#include "xr/runtime_clock.h"
#include "xr/session_impl.h"

namespace stylet::xr {
namespace {

using SteadyClock = std::chrono::steady_clock;

// Time limit for the session to end after a requested exit.
constexpr auto kExitTimeout = std::chrono::milliseconds(600);
// Time limit of the destructor, after which a detached thread finishes the work: some runtimes never return
// from xrDestroyInstance.
constexpr auto kDestroyTimeout = std::chrono::milliseconds(1000);

}  // namespace

Session::Impl::Impl(const std::string& application_name, const SessionSettings& settings_in)
    : settings(settings_in),
      instance(application_name, notes),
      headset(readHeadset(instance, settings.passthrough, notes)) {
    facts.runtime_name = instance.runtime_name;
    facts.runtime_version = instance.runtime_version;
    facts.system_name = instance.system_name;
    facts.extensions = instance.extensions;
    facts.blend_mode = blendModeName(headset.blend_mode);
    facts.width = headset.width;
    facts.height = headset.height;
}

Session::Session(const std::string& application_name, const SessionSettings& settings)
    : impl_(std::make_unique<Impl>(application_name, settings)) {}

Session::~Session() {
    impl_->has_focus = false;
    std::promise<void> destroyed;
    const std::future<void> done = destroyed.get_future();
    std::thread destroyer([impl = std::move(impl_), destroyed = std::move(destroyed)]() mutable {
        impl->endSession();
        impl.reset();
        destroyed.set_value();
    });
    if (done.wait_for(kDestroyTimeout) == std::future_status::ready)
        destroyer.join();
    else
        destroyer.detach();
}

void Session::Impl::endSession() {
    if (!state_machine.running) return;
    try {
        requestExit();
        const auto deadline = SteadyClock::now() + kExitTimeout;
        while (poll() != SessionPhase::exiting && !state_machine.isFinal() && SteadyClock::now() < deadline)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } catch (const XrError&) {
        // The session is destroyed next. That is allowed in every state.
    }
}

const std::string& Session::runtimeName() const {
    return impl_->facts.runtime_name;
}
const RuntimeFacts& Session::facts() const {
    return impl_->facts;
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
    auto binding = makeStruct<XrGraphicsBindingVulkan2KHR>(XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
    binding.instance = vulkan;
    binding.physicalDevice = gpu;
    binding.device = device;
    binding.queueFamilyIndex = queue_family;
    auto info = makeStruct<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
    info.next = &binding;
    info.systemId = s.instance.system;
    check(xrCreateSession(s.instance.handle.get(), &info, s.session.out()), "xrCreateSession",
          fmt::format("runtime \"{}\" refuses a session: quit other VR programs and start again",
                      s.instance.runtime_name));
    const XrSession session = s.session.get();
    s.spaces.create(s.instance, session, s.settings.stationary, s.notes);
    s.facts.space = s.spaces.name();
    s.input.create(s.instance, session, s.notes);
    s.facts.refresh_hz = refreshRate_hz(s.instance, session);
    s.formats = offeredFormats(session);
    // TRANSFER_SRC: the instructor's window shows a copy of one eye.
    s.colour.create(session, {chooseColourFormat(s.formats),
                              XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
                                  XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT,
                              s.headset.width, s.headset.height, 2});
}

void Session::keepAlive(std::shared_ptr<void> device) {
    impl_->device_owner = std::move(device);
}
VkFormat Session::colourFormat() const {
    return impl_->colour.format();
}
std::uint32_t Session::width() const {
    return impl_->headset.width;
}
std::uint32_t Session::height() const {
    return impl_->headset.height;
}
bool Session::running() const {
    return impl_->state_machine.running;
}

void Session::setDepthRange(float near_m, float far_m) {
    Impl& s = *impl_;
    const bool first = !s.depth_range;
    s.depth_range = DepthRange{near_m, far_m};
    if (!first || !s.instance.has(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME)) return;
    constexpr VkFormat kFormat = VK_FORMAT_D32_SFLOAT;
    if (std::find(s.formats.begin(), s.formats.end(), kFormat) == s.formats.end()) {
        s.notes.push_back("xrEnumerateSwapchainFormats: the runtime offers no 32-bit depth format");
        return;
    }
    try {
        s.depth.create(s.session.get(),
                       {kFormat,
                        XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
                            XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                        s.headset.width, s.headset.height, 2});
    } catch (const XrError& e) {
        s.notes.push_back(e.what());
    }
}

HiddenArea Session::hiddenArea(int eye) const {
    return xr::hiddenArea(impl_->instance, impl_->session.get(), eye);
}

int Session::addPanel(std::uint32_t width, std::uint32_t height) {
    Impl& s = *impl_;
    try {
        return s.panels.add(s.session.get(), panelFormat(), width, height);
    } catch (const XrError& e) {
        s.notes.push_back(e.what());
        return -1;
    }
}
VkFormat Session::panelFormat() const {
    return impl_->colour.format();
}

VkImage Session::acquirePanel(int id) {
    Impl& s = *impl_;
    // A short timeout is enough, because the panel can also be updated in the next frame.
    constexpr XrDuration kPanelTimeout_ns = 2'000'000;
    Swapchain* panel = s.panels.find(id);
    if (!panel || s.state_machine.isFinal()) return VK_NULL_HANDLE;
    bool ready = false;
    const bool not_lost = s.succeeded(panel->acquire(ready, kPanelTimeout_ns), "xrAcquireSwapchainImage",
                                      "no image to draw a panel into");
    return not_lost && ready ? panel->image() : VK_NULL_HANDLE;
}

void Session::releasePanel(int id) {
    Swapchain* panel = impl_->panels.find(id);
    if (panel && panel->isReady())
        impl_->succeeded(panel->release(), "xrReleaseSwapchainImage",
                         "the image of a panel cannot be released");
}

Hand Session::hand(int side) const {
    return impl_->input.hand(side);
}

std::optional<Pose> Session::gripAt(int side, std::int64_t when_ns) const {
    const Impl& s = *impl_;
    if (!s.has_focus) return std::nullopt;
    std::optional<XrTime> time;
    if (!s.settings.virtual_clock) time = toRuntimeTime(s.instance, when_ns);
    const XrTime at = time.value_or(s.last_display);
    if (at <= 0) return std::nullopt;
    return s.input.gripAt(s.spaces.stage(), at, side);
}

std::optional<std::int64_t> Session::monotonic_ns(std::int64_t runtime_ns) const {
    if (impl_->settings.virtual_clock) return std::nullopt;
    return toMonotonicTime(impl_->instance, runtime_ns);
}

std::string Session::spaceGeneration() const {
    return impl_->spaces.generation(impl_->instance, impl_->session.get());
}

void Session::pulse(int side, float amplitude, std::int64_t duration_ns) {
    impl_->handleLoss(impl_->input.pulse(impl_->session.get(), side, amplitude, duration_ns));
}

void Session::requestExit() {
    impl_->requestExit();
}
void Session::Impl::requestExit() {
    const XrResult result = xrRequestExitSession(session.get());
    if (result != XR_ERROR_SESSION_NOT_RUNNING)
        succeeded(result, "xrRequestExitSession", "the runtime does not end the session");
}

void Session::markCapture(const std::string& label) {
    Impl& s = *impl_;
    if (!s.instance.calls.insertLabel) return;
    const std::string name = "capture:" + label;
    const XrDebugUtilsLabelEXT info{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name.c_str()};
    s.handleLoss(s.instance.calls.insertLabel(s.session.get(), &info));
}

}  // namespace stylet::xr
