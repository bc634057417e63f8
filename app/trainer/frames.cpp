#include "app/trainer/frames.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>
#include <vector>

#include <unistd.h>

#include "render/render.h"
#include "xr/xr.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr auto kStartPatience = std::chrono::seconds(10);
// A moment waits this many frames for one that is to be drawn: a session shows nothing in its first few.
constexpr int kMomentTries = 20;

patient::Pose poseOf(const xr::Pose& p) {
    return {patient::Quat{p.orientation[3], p.orientation[0], p.orientation[1], p.orientation[2]},
            patient::Vec3{p.position[0], p.position[1], p.position[2]}};
}

std::array<render::View, 2> viewsOf(const xr::Frame& frame) {
    std::array<render::View, 2> views;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const xr::EyeView& from = frame.views[eye];
        views[eye] = {poseOf(from.stage_from_eye), from.angle_left, from.angle_right, from.angle_up,
                      from.angle_down};
    }
    return views;
}

void addTo(render::RenderStats& sum, const render::RenderStats& one) {
    sum.gpu_ms += one.gpu_ms;
    sum.samples += one.samples;
    sum.rays += one.rays;
    sum.skipped_bricks += one.skipped_bricks;
    sum.terminated_rays += one.terminated_rays;
    sum.depth_bounded_rays += one.depth_bounded_rays;
    sum.still_frames += one.still_frames;
}

render::GpuHooks hooksOf(xr::Session& session) {
    return {[&session](auto loader, auto info, auto out) {
                return session.createVulkanInstance(loader, info, out);
            },
            [&session](VkInstance vulkan) { return session.vulkanPhysicalDevice(vulkan); },
            [&session](auto loader, auto gpu, auto info, auto out) {
                return session.createVulkanDevice(loader, gpu, info, out);
            }};
}

// The head the mock runtime shows while it is made: the caller's, or one written from the path into
// `scratch`.
void stageMock(const FrameSettings& settings, const patient::Pose& stage_from_patient,
               const patient::PlannedPath& path, const std::filesystem::path& scratch) {
    if (settings.head_script.empty()) writeHeadScript(scratch, stage_from_patient, path);
    setUpMock(settings.head_script.empty() ? scratch : settings.head_script, settings.virtual_clock,
              settings.capture_dir);
}

struct Removed {
    std::filesystem::path file;
    ~Removed() {
        std::error_code nothing_there;
        std::filesystem::remove(file, nothing_there);
    }
};

double medianOf(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

struct FrameLoop::Impl {
    Impl(const patient::Patient& patient_in, const FrameSettings&, const patient::PlannedPath&,
         const patient::Pose& stage_from_patient_in);
    void waitUntilRunning();
    render::RenderScene sceneOf(const haptics::TickOutput&) const;
    // One frame; true when it was drawn.
    bool show(const haptics::TickOutput&, const std::string& moment);

    const patient::Patient& patient;
    const patient::PlannedPath path;
    const patient::Pose stage_from_patient;
    const bool virtual_clock;
    // The session asks for its GPU through the hooks and must be gone before the device is.
    std::optional<render::Gpu> gpu;
    xr::Session session;
    std::optional<render::Renderer> renderer;
    bool focused = false;
    FrameTotals totals;
    std::vector<double> frame_ms;
};

FrameLoop::Impl::Impl(const patient::Patient& patient_in, const FrameSettings& settings,
                      const patient::PlannedPath& path_in, const patient::Pose& stage_from_patient_in)
    : patient(patient_in),
      path(path_in),
      stage_from_patient(stage_from_patient_in),
      virtual_clock(settings.virtual_clock),
      session("Stylet") {
    render::GpuSettings gpu_settings;
    gpu_settings.validation = settings.validation;
    gpu.emplace(gpu_settings, hooksOf(session));
    session.start(*gpu->instance(), *gpu->physicalDevice(), *gpu->device(), gpu->queueFamily());
    renderer.emplace(*gpu, settings.render, settings.assets);
    renderer->setPatient(patient);
    totals.runtime = session.runtimeName();
    totals.gpu = gpu->name();
    waitUntilRunning();
}

void FrameLoop::Impl::waitUntilRunning() {
    const auto deadline = SteadyClock::now() + kStartPatience;
    while (session.poll(), !session.running()) {
        if (SteadyClock::now() > deadline)
            throw xr::XrError("xrPollEvent: the runtime \"" + totals.runtime +
                              "\" did not become ready: is the headset switched on?");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

render::RenderScene FrameLoop::Impl::sceneOf(const haptics::TickOutput& shown) const {
    render::RenderScene scene;
    scene.stage_from_patient = stage_from_patient;
    scene.breath = shown.breath;
    if (haptics::holdsNeedle(shown.tool)) scene.patient_from_needle = shown.patient_from_needle;
    const patient::MotionModel& model = patient.package().motion;
    scene.reference_path_m = {patient::deformedFromReference(model, shown.breath, path.entry_reference_m),
                              patient::deformedFromReference(model, shown.breath, path.target_reference_m)};
    return scene;
}

bool FrameLoop::Impl::show(const haptics::TickOutput& shown, const std::string& moment) {
    const xr::Frame frame = session.beginFrame();
    const auto begin = SteadyClock::now();
    ++totals.frames;
    if (frame.should_render) {
        const render::StereoTarget target{frame.image, session.colourFormat(), session.width(),
                                          session.height()};
        addTo(totals.sum, renderer->draw(sceneOf(shown), viewsOf(frame), target));
        if (!moment.empty()) session.markMoment(moment);
        ++totals.rendered;
    }
    session.endFrame(frame);
    if (frame.should_render)
        frame_ms.push_back(std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count());
    return frame.should_render;
}

FrameLoop::FrameLoop(const patient::Patient& patient, const FrameSettings& settings,
                     const patient::PlannedPath& path) {
    // The loader would print what our own error says in a sentence.
    setenv("XR_LOADER_DEBUG", "none", 0);
    const patient::Pose stage_from_patient = stageFromPatient(patient, path);
    const auto scratch =
        std::filesystem::temp_directory_path() / ("stylet-head-" + std::to_string(getpid()) + ".json");
    const Removed removed{scratch};
    if (mockRuntimeChosen()) stageMock(settings, stage_from_patient, path, scratch);
    impl_ = std::make_unique<Impl>(patient, settings, path, stage_from_patient);
}

FrameLoop::~FrameLoop() = default;

bool FrameLoop::frame(const haptics::TickOutput& shown, const std::string& moment) {
    Impl& loop = *impl_;
    const int tries = moment.empty() ? 1 : kMomentTries;
    for (int tried = 0; tried < tries; ++tried) {
        const xr::SessionPhase phase = loop.session.poll();
        loop.focused = phase == xr::SessionPhase::focused;
        if (phase == xr::SessionPhase::exiting || phase == xr::SessionPhase::lossPending) return false;
        if (!loop.session.running()) {
            if (!loop.virtual_clock) std::this_thread::sleep_for(std::chrono::milliseconds(10));
            break;
        }
        if (loop.show(shown, moment)) return true;
    }
    if (!moment.empty())
        std::fprintf(stderr, "stylet: no picture of the moment \"%s\": the runtime is not showing pictures\n",
                     moment.c_str());
    return true;
}

bool FrameLoop::focused() const {
    return impl_->focused;
}

FrameTotals FrameLoop::totals() const {
    FrameTotals totals = impl_->totals;
    totals.validation_messages = impl_->gpu->validationMessages();
    totals.median_frame_ms = medianOf(impl_->frame_ms);
    return totals;
}

}  // namespace stylet::trainer
