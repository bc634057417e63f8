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
        render::GpuSettings gpu_settings;
        gpu_settings.validation = settings.validation;
        gpu_settings.pipeline_cache = settings.pipeline_cache.string();
        gpu = std::make_shared<render::Gpu>(gpu_settings, hooksOf(session));
        session.keep(gpu);
        session.start(*gpu->instance(), *gpu->physicalDevice(), *gpu->device(), gpu->queueFamily());
        renderer.emplace(*gpu, render::RenderSettings{}, settings.assets);
        card.emplace(session, *gpu, RegisterCard::kWidth, RegisterCard::kHeight);
        ready_by = std::chrono::steady_clock::now() + kStartPatience;
    }

    RegisterAnswer frame(const RegisterShown& shown);
    void draw(const RegisterShown&, xr::Frame&);
    void readHand(RegisterAnswer&) const;

    const int side;
    std::shared_ptr<render::Gpu> gpu;  // must outlive the session, which keeps a reference
    xr::Session session;
    std::optional<render::Renderer> renderer;
    std::optional<Panel> card;
    NoticePlace place;
    bool was_running = false;
    std::chrono::steady_clock::time_point ready_by;
};

void RegisterRoom::readHand(RegisterAnswer& answer) const {
    for (const int hand : {0, 1}) {  // the other hand may press as well
        const xr::Hand read = session.hand(hand);
        answer.select |= read.active && read.select;
        answer.menu |= read.active && read.menu;
        if (hand == side) answer.bare = read.bare;
    }
}

void RegisterRoom::draw(const RegisterShown& shown, xr::Frame& frame) {
    render::RenderScene scene;
    scene.table = false;
    scene.room.shell = !gpu->isProcessor();               // on a processor it would starve the device thread
    scene.patient_from_needle = shown.stage_from_needle;  // no patient: the patient frame is the stage frame
    session.lateUpdate(frame);
    const std::array<render::View, 2> views = viewsOf(frame, {});
    renderer->draw(
        scene, views,
        {frame.image, session.colourFormat(), session.width(), session.height(), frame.depth_image});
    if (!card->show(shown.rgba, shown.revision)) return session.endFrame(frame);
    const xr::EyeView& eye = frame.views[0];
    const double breadth = std::tan(double(eye.angle_right)) - std::tan(double(eye.angle_left));
    xr::ShownPanel panel;
    panel.id = card->id();
    // Above the hands, not in front of them.
    Pose raised = headOf(views);
    raised.rotation = raised.rotation * glm::angleAxis(kRaised_rad, Vec3(1.0, 0.0, 0.0));
    panel.stage_from_panel = poseOf(place.of(raised));
    panel.width_m = RegisterCard::kWidth / RegisterCard::kLetter_px * NoticePlace::kDistance_m *
                    std::tan(letterAngle_rad(session.width() / breadth));
    panel.height_m = panel.width_m * RegisterCard::kHeight / RegisterCard::kWidth;
    session.endFrame(frame, {&panel, 1});
}

RegisterAnswer RegisterRoom::frame(const RegisterShown& shown) {
    RegisterAnswer answer;
    const xr::SessionPhase phase = session.poll();
    if (phase == xr::SessionPhase::lossPending)
        throw std::runtime_error("the headset was lost: the OpenXR runtime ended the session");
    answer.over = phase == xr::SessionPhase::exiting;
    answer.space_moved = !session.takeNews().spaces.empty();
    if (answer.over) return answer;
    if (!session.running()) {
        if (!was_running && std::chrono::steady_clock::now() > ready_by)
            throw std::runtime_error("the runtime \"" + session.runtimeName() +
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
    setenv("XR_LOADER_DEBUG", "none", 0);  // our own error replaces the loader's messages
    try {
        const auto room = std::make_shared<RegisterRoom>(settings);
        return RegisterView{[room](const RegisterShown& shown) { return room->frame(shown); },
                            [room](std::int64_t when_ns) -> std::optional<Pose> {
                                const auto grip = room->session.gripAt(room->side, when_ns);
                                if (!grip) return std::nullopt;
                                return poseOf(*grip);
                            },
                            [room] { return room->session.facts().space; },
                            [room] { return room->session.spaceGeneration(); }};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

}  // namespace stylet::trainer
