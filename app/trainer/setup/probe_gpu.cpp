#include "app/trainer/setup/probe.h"

#include <fmt/core.h>
#include <filesystem>
#include <thread>

#include "app/trainer/display/headset.h"
#include "app/trainer/display/runtime_manifest.h"
#include "render/render.h"
#include "xr/xr.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr double kReadyWithin = 0.3, kFocusWithin = 0.3;  // fractions of the patience
constexpr double kComfortable_hz = 89.0;

std::string listed(const std::vector<std::string>& all) {
    std::string text;
    for (const std::string& one : all)
        text += (text.empty() ? "" : ", ") + one;
    return text.empty() ? "none" : text;
}

Finding gpuFinding(const render::Gpu& gpu) {
    const auto chain =
        gpu.physicalDevice()
            .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
    const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
    const std::string text =
        fmt::format("{}; driver {} {}", gpu.name(), driver.driverName.data(), driver.driverInfo.data());
    if (gpu.isSoftware())
        return {"graphics", FindingState::warning, text + ": Vulkan in software",
                "a frame takes tenths of a second: install the Vulkan driver of the graphics card"};
    return {"graphics", FindingState::ok, text};
}

// Draws black frames, so that a user who wears the headset sees nothing strange during the check.
class Curtain {
  public:
    explicit Curtain(const render::Gpu& gpu, VkFormat format)
        : gpu_(gpu),
          format_(format),
          pool_(gpu.device(),
                vk::CommandPoolCreateInfo{.flags = vk::CommandPoolCreateFlagBits::eResetCommandBuffer,
                                          .queueFamilyIndex = gpu.queueFamily()}),
          commands_(gpu.device(), vk::CommandBufferAllocateInfo{.commandPool = *pool_,
                                                                .level = vk::CommandBufferLevel::ePrimary,
                                                                .commandBufferCount = 1}) {}

    void draw(VkImage image, std::uint32_t width, std::uint32_t height) {
        const vk::ImageSubresourceRange both{
            .aspectMask = vk::ImageAspectFlagBits::eColor, .levelCount = 1, .layerCount = 2};
        const vk::raii::ImageView view(gpu_.device(),
                                       vk::ImageViewCreateInfo{.image = image,
                                                               .viewType = vk::ImageViewType::e2DArray,
                                                               .format = vk::Format(format_),
                                                               .subresourceRange = both});
        const vk::RenderingAttachmentInfo colour{.imageView = *view,
                                                 .imageLayout = vk::ImageLayout::eColorAttachmentOptimal,
                                                 .loadOp = vk::AttachmentLoadOp::eClear,
                                                 .storeOp = vk::AttachmentStoreOp::eStore};
        const vk::raii::CommandBuffer& commands = commands_.front();
        commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
        commands.beginRendering(vk::RenderingInfo{.renderArea = {.extent = {width, height}},
                                                  .layerCount = 2,
                                                  .colorAttachmentCount = 1,
                                                  .pColorAttachments = &colour});
        commands.endRendering();
        commands.end();
        const vk::CommandBuffer submitted = *commands;
        gpu_.queue().submit(vk::SubmitInfo{.commandBufferCount = 1, .pCommandBuffers = &submitted});
        gpu_.queue().waitIdle();
    }

  private:
    const render::Gpu& gpu_;
    VkFormat format_;
    vk::raii::CommandPool pool_;
    vk::raii::CommandBuffers commands_;
};

// Finds the manifest that the loader will use, and the library that it names. Returns false if the check
// cannot continue.
bool findRuntime(const ProbeReport& report) {
    const std::vector<std::string> places = xr::runtimeSearchPath();
    std::filesystem::path manifest;
    for (const std::string& place : places)
        if (std::error_code none; manifest.empty() && std::filesystem::exists(place, none)) manifest = place;
    const auto refuse = [&](const std::string& found, const std::string& todo) {
        report.found({"runtime", FindingState::problem, found, todo});
        return false;
    };
    if (manifest.empty())
        return refuse("none found; looked at " + listed(places),
                      "start the headset's runtime once, or set XR_RUNTIME_JSON to its manifest; without it "
                      "the trainer has no headset");
    const std::string name = readLibraryPath(manifest);
    if (name.empty())
        return refuse(manifest.string() + " is not a runtime manifest: runtime.library_path is missing",
                      "reinstall the runtime, or set XR_RUNTIME_JSON to a valid manifest");
    // The system's loader searches for a name without a slash. A name with a slash is absolute or relative
    // to the manifest.
    const std::filesystem::path library = manifest.parent_path() / name;
    if (std::error_code none; name.find('/') != std::string::npos && !std::filesystem::exists(library, none))
        return refuse(manifest.string() + " names " + library.string() + ", which does not exist",
                      "reinstall the runtime, or set XR_RUNTIME_JSON to the manifest of another one");
    report.found({"runtime", FindingState::ok, manifest.string() + ", " + name});
    return true;
}

struct Reached {
    xr::SessionPhase phase = xr::SessionPhase::idle;
    bool bound = false;
};

// Runs frames until the session has the focus and a controller is bound, or until the time is up.
Reached runFrames(xr::Session& session, Curtain& curtain, const ProbeReport& report,
                  std::chrono::milliseconds patience) {
    const auto within = [&](double share) {
        return SteadyClock::now() + std::chrono::duration_cast<SteadyClock::duration>(share * patience);
    };
    Reached reached;
    report.about("becoming ready");
    const auto ready_by = within(kReadyWithin);
    while (reached.phase = session.poll(), !session.running() && SteadyClock::now() < ready_by)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    report.about("its first frames");
    const auto focus_by = within(kFocusWithin);
    while (session.running() && SteadyClock::now() < focus_by && !reached.bound) {
        const xr::Frame frame = session.beginFrame();
        if (frame.should_render) curtain.draw(frame.image, session.width(), session.height());
        session.endFrame(frame);
        reached.phase = session.poll();
        const auto& profiles = session.facts().profiles;
        reached.bound = reached.phase == xr::SessionPhase::focused && (profiles[0] + profiles[1]) != "";
    }
    return reached;
}

void reportSession(const xr::Session& session, const Reached& reached, const ProbeReport& report) {
    const xr::RuntimeFacts& facts = session.facts();
    const bool seen =
        reached.phase == xr::SessionPhase::visible || reached.phase == xr::SessionPhase::focused;
    if (reached.phase == xr::SessionPhase::focused) {
        report.found({"session", FindingState::ok, "shown, with the focus"});
    } else if (seen || session.running()) {
        report.found({"session", FindingState::warning,
                      seen ? "shown, but another program has the focus" : "started, but not shown",
                      "put the headset on and close other applications; the force stays off until then"});
    } else {
        report.found({"session", FindingState::problem, "the runtime does not start it",
                      "switch the headset on, put it on, and check the runtime's messages"});
    }
    const bool slow = facts.refresh_hz > 0.0 && facts.refresh_hz < kComfortable_hz;
    const std::string rate =
        facts.refresh_hz > 0.0 ? fmt::format("{:.0f} Hz", facts.refresh_hz) : "refresh rate not reported";
    report.found(warnUnless(
        !slow, "display",
        fmt::format("{} x {} an eye, {}, blending {}", facts.width, facts.height, rate, facts.blend_mode),
        "90 Hz are easier on the eyes: choose them in the runtime's settings"));
    report.found(
        warnUnless(facts.space != "local", "space", facts.space,
                   "the runtime reports no floor: set up its room, or the table's height is estimated"));
    const auto profile = [&](int hand) {
        return facts.profiles[hand].empty() ? "nothing" : facts.profiles[hand];
    };
    report.found(warnUnless(reached.bound, "controllers",
                            fmt::format("left {}, right {}", profile(0), profile(1)),
                            "switch a controller on: it registers the device and can be the input"));
}

void checkHeadset(xr::Session& session, std::optional<render::Gpu>& gpu, const ProbeReport& report,
                  std::chrono::milliseconds patience) {
    const xr::RuntimeFacts& facts = session.facts();
    report.found({"runtime answers", FindingState::ok, facts.runtime_name + " " + facts.runtime_version});
    report.found({"headset", FindingState::ok, facts.system_name});
    report.found({"extensions", FindingState::ok, listed(facts.extensions)});
    report.about("its graphics device");
    gpu.emplace(render::GpuSettings{}, makeGpuHooks(session));
    Finding drawn_by = gpuFinding(*gpu);
    drawn_by.what = "graphics of the headset";
    report.found(drawn_by);
    report.about("a session");
    session.start(*gpu->instance(), *gpu->physicalDevice(), *gpu->device(), gpu->queueFamily());
    Reached reached;
    {
        Curtain curtain(*gpu, session.colourFormat());
        reached = runFrames(session, curtain, report, patience);
    }
    reportSession(session, reached, report);
    for (const std::string& note : session.notes())
        report.found(
            {"runtime refuses", FindingState::warning, note, "nothing to do: the trainer does not need it"});
}

void checkRuntime(const ProbeReport& report, std::chrono::milliseconds patience) {
    report.about("loading it and querying its headset");
    std::optional<render::Gpu> gpu;  // outlives the session
    xr::Session session("Stylet doctor");
    try {
        checkHeadset(session, gpu, report, patience);
    } catch (const std::exception& e) {
        report.found({"headset refuses", FindingState::problem, e.what(),
                      "restart the headset's runtime and check its messages"});
    }
    report.about("its end");
}

}  // namespace

void probeRuntime(const ProbeReport& report, std::chrono::milliseconds patience) {
    try {
        report.about("reading its manifest");
        if (findRuntime(report)) checkRuntime(report, patience);
    } catch (const std::exception& e) {
        report.found({"headset", FindingState::problem, e.what(),
                      "connect the headset, start its runtime and check its messages"});
    }
}

void probeVulkan(const ProbeReport& report) {
    report.about("querying Vulkan for a graphics card");
    try {
        report.found(gpuFinding(render::Gpu(render::GpuSettings{})));
    } catch (const std::exception& e) {
        report.found({"graphics", FindingState::problem, e.what(),
                      "install the graphics card's Vulkan driver (Debian: mesa-vulkan-drivers)"});
    }
}

}  // namespace stylet::trainer
