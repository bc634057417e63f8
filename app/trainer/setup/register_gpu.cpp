#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <thread>

#include "app/trainer/display/headset.h"
#include "app/trainer/display/panels.h"
#include "app/trainer/setup/register_card.h"
#include "app/trainer/setup/register_view.h"

namespace stylet::trainer {
namespace {

constexpr auto kNap = std::chrono::milliseconds(10);
constexpr double kRaised_rad = 0.35;

// Draws the room without a patient, the card, and a needle at the estimated tip.
struct RegisterRoom {
    explicit RegisterRoom(const RegisterViewSettings& settings)
        : side(settings.side), session("Stylet", {.stationary = true}) {
        gpu = std::make_shared<render::Gpu>(
            render::GpuSettings{.validation = settings.validation, .pipeline_cache = settings.pipeline_cache},
            makeGpuHooks(session));
        session.keepAlive(gpu);
        session.start(*gpu->instance(), *gpu->physicalDevice(), *gpu->device(), gpu->queueFamily());
        renderer.emplace(*gpu, render::RenderSettings{}, settings.assets);
        card.emplace(session, *gpu, RegisterCard::kWidth, RegisterCard::kHeight);
        ready_by = std::chrono::steady_clock::now() + kStartPatience;
    }

    RegisterInput frame(const RegisterFrame& shown);
    void draw(const RegisterFrame&, xr::Frame&);
    void readHand(RegisterInput&) const;

    const int side;
    std::shared_ptr<render::Gpu> gpu;  // must outlive the session, which keeps a reference
    xr::Session session;
    std::optional<render::Renderer> renderer;
    std::optional<Panel> card;
    NoticePlace place;
    bool was_running = false;
    std::chrono::steady_clock::time_point ready_by;
};

void RegisterRoom::readHand(RegisterInput& answer) const {
    for (const int hand : {0, 1}) {  // the buttons of the other hand count as well
        const xr::Hand read = session.hand(hand);
        answer.select |= read.active && read.select;
        answer.menu |= read.active && read.menu;
        if (hand == side) answer.bare = read.bare;
    }
}

void RegisterRoom::draw(const RegisterFrame& shown, xr::Frame& frame) {
    render::RenderScene scene;
    scene.table = false;
    // On a processor, drawing the room would take CPU time from the device thread.
    scene.room.shell = !gpu->isSoftware();
    scene.patient_from_needle = shown.stage_from_needle;  // no patient: the patient frame is the stage frame
    session.lateUpdate(frame);
    const std::array<render::View, 2> views = eyeViews(frame, {});
    renderer->draw(
        scene, views,
        {frame.image, session.colourFormat(), session.width(), session.height(), frame.depth_image});
    if (!card->show(shown.rgba, shown.revision)) return session.endFrame(frame);
    const xr::EyeView& eye = frame.views[0];
    const double breadth = std::tan(double(eye.angle_right)) - std::tan(double(eye.angle_left));
    xr::ShownPanel panel;
    panel.id = card->id();
    // Place the card above the hands, so that it does not hide them.
    Pose raised = headPose(views);
    raised.rotation = raised.rotation * glm::angleAxis(kRaised_rad, Vec3(1.0, 0.0, 0.0));
    panel.stage_from_panel = place.of(raised);
    panel.width_m = RegisterCard::kWidth / RegisterCard::kLetter_px * NoticePlace::kDistance_m *
                    std::tan(letterAngle_rad(session.width() / breadth));
    panel.height_m = panel.width_m * RegisterCard::kHeight / RegisterCard::kWidth;
    session.endFrame(frame, {&panel, 1});
}

RegisterInput RegisterRoom::frame(const RegisterFrame& shown) {
    RegisterInput answer;
    const xr::SessionPhase phase = session.poll();
    if (phase == xr::SessionPhase::lossPending)
        throw EnvironmentError("the headset was lost: the OpenXR runtime ended the session");
    answer.over = phase == xr::SessionPhase::exiting;
    answer.space_moved = !session.popEvents().spaces.empty();
    if (answer.over) return answer;
    if (!session.running()) {
        if (!was_running && std::chrono::steady_clock::now() > ready_by)
            throw EnvironmentError("the runtime \"" + session.runtimeName() +
                                   "\" did not become ready: is the headset switched on?");
        std::this_thread::sleep_for(kNap);
        return answer;
    }
    was_running = true;
    xr::Frame made = session.beginFrame();
    answer.seen = made.should_render;
    if (made.should_render)
        draw(shown, made);
    else
        session.endFrame(made);
    readHand(answer);
    return answer;
}

}  // namespace

std::optional<RegisterView> openRegisterView(const RegisterViewSettings& settings, std::string& why_not) {
    setenv("XR_LOADER_DEBUG", "none", 0);  // our own error message replaces the loader's messages
    try {
        const auto room = std::make_shared<RegisterRoom>(settings);
        return RegisterView{[room](const RegisterFrame& shown) { return room->frame(shown); },
                            [room](std::int64_t when_ns) -> std::optional<Pose> {
                                return room->session.gripAt(room->side, when_ns);
                            },
                            [room] { return room->session.facts().space; },
                            [room] { return room->session.spaceGeneration(); }};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

}  // namespace stylet::trainer
