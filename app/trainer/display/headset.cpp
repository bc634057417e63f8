#include "app/trainer/display/headset.h"

#include <cmath>
#include <thread>

#include "app/trainer/stores/console.h"

namespace stylet::trainer {

render::GpuHooks makeGpuHooks(xr::Session& session) {
    return {[&session](auto loader, auto info, auto out) {
                return session.createVulkanInstance(loader, info, out);
            },
            [&session](VkInstance vulkan) { return session.vulkanPhysicalDevice(vulkan); },
            [&session](auto loader, auto gpu, auto info, auto out) {
                return session.createVulkanDevice(loader, gpu, info, out);
            }};
}

std::array<render::View, 2> eyeViews(const xr::Frame& frame, const Pose& room_from_stage) {
    std::array<render::View, 2> views;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const xr::EyeView& from = frame.views[eye];
        views[eye] = {room_from_stage * from.stage_from_eye, from.angle_left, from.angle_right, from.angle_up,
                      from.angle_down};
    }
    return views;
}

Pose headPose(const std::array<render::View, 2>& views) {
    return {views[0].stage_from_eye.rotation,
            0.5 * (views[0].stage_from_eye.position_m + views[1].stage_from_eye.position_m)};
}

namespace {

render::RenderSettings renderSettings(const AttemptConfig& config) {
    render::RenderSettings settings;
    settings.count = config.stats;
    if (config.foveation) settings.foveation.emplace();
    return settings;
}

}  // namespace

Headset::Headset(const patient::Patient& patient, const PictureSettings& settings)
    : session("Stylet", {.passthrough = settings.config.passthrough,
                         .stationary = settings.colocation &&
                                       settings.colocation->registration.key.space == "stationary",
                         .virtual_clock = settings.config.fast}),
      drawn(renderSettings(settings.config)) {
    gpu = std::make_shared<render::Gpu>(render::GpuSettings{.validation = settings.config.validation,
                                                            .pipeline_cache = settings.pipeline_cache},
                                        makeGpuHooks(session));
    session.keepAlive(gpu);
    session.start(*gpu->instance(), *gpu->physicalDevice(), *gpu->device(), gpu->queueFamily());
    renderer.emplace(*gpu, drawn, settings.assets);
    loadSceneLook(*renderer, settings.config);
    renderer->setPatient(patient);
    equipment_pictures.emplace(*gpu, renderer->deformedPatient(), settings.assets);
    session.setDepthRange(drawn.near_m, drawn.far_m);
    for (const int eye : {0, 1})
        updateHiddenArea(eye);
    for (const auto& notes : {session.notes(), renderer->notes()})
        for (const std::string& note : notes)
            printMessage(note);
}

void Headset::updateHiddenArea(int eye) {
    const xr::HiddenArea area = session.hiddenArea(eye);
    std::vector<glm::vec2> tangents;
    for (const auto& [right, up] : area.tangents)
        tangents.emplace_back(right, up);
    renderer->setHiddenArea(eye, tangents, area.indices);
}

HeadsetPanels& Headset::panelsFor(const xr::Frame& frame) {
    if (!panels) {
        const xr::EyeView& eye = frame.views[0];
        const double breadth = std::tan(double(eye.angle_right)) - std::tan(double(eye.angle_left));
        panels.emplace(session, *gpu, session.width() / breadth);
    }
    return *panels;
}

void Headset::waitUntilRunning(std::chrono::seconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (session.poll(), !session.running()) {
        if (std::chrono::steady_clock::now() > deadline)
            throw xr::XrError("xrPollEvent: the runtime \"" + session.runtimeName() +
                              "\" did not become ready: is the headset switched on?");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

void Headset::adaptToBudget(const xr::Frame& frame, std::optional<double> budget_ms) {
    if (!governor) {
        const double pace_ms = gpu->isSoftware() ? 0.0 : 1e-6 * double(frame.predicted_display_period_ns);
        const double wanted_ms = budget_ms.value_or(pace_ms);
        if (wanted_ms <= 0.0) return;
        governor.emplace(render::GovernorSettings{.budget_ms = wanted_ms});
    }
    drawn.layer_scale = governor->layerScale();
    renderer->setSettings(drawn);
}

}  // namespace stylet::trainer
