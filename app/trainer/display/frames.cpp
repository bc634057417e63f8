#include "app/trainer/display/frames.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>
#include <vector>

#include "app/trainer/display/headset.h"
#include "app/trainer/display/mock_stage.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/view/first_picture.h"
#include "app/trainer/view/scene.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr auto kLookAgain = std::chrono::seconds(1);  // interval of the search for a lost headset
// Consecutive frames without rendering after which the user no longer sees the scene.
constexpr int kBlindFrames = 5;
// A capture is tried in this many frames, because a new session renders nothing in its first frames.
constexpr int kMomentTries = 20;

bool isLate(const xr::Session& session, const xr::Frame& frame) {
    const auto display_ns = session.monotonic_ns(frame.predicted_display_time_ns);
    const auto now = SteadyClock::now().time_since_epoch();
    return display_ns && std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() > *display_ns;
}

void addTo(render::RenderStats& sum, const render::RenderStats& one) {
    sum.gpu_ms += one.gpu_ms;
    sum.samples += one.samples;
    sum.rays += one.rays;
    sum.skipped_bricks += one.skipped_bricks;
    sum.terminated_rays += one.terminated_rays;
    sum.depth_bounded_rays += one.depth_bounded_rays;
    sum.still_frames += one.still_frames;
    sum.idle_tool_frames += one.idle_tool_frames;
    sum.culled_parts += one.culled_parts;
    sum.reused_shadows += one.reused_shadows;
}

}  // namespace

struct FrameLoop::Impl {
    Impl(const patient::Patient& patient_in, const PictureSettings&, const patient::PlannedPath&);
    ~Impl();
    // Returns true if there is a headset. If the headset is lost, searches for one at intervals.
    bool found();
    // Places the room in the space of a newly found headset.
    void settle();
    void passController(const Pose& room_from_stage);
    void lose(const std::string& why);
    FrameState upToDate(const FrameState&, const std::string& moment);
    haptics::TickOutput predictTick(const xr::Frame&, const haptics::TickOutput&);
    void pollSessionEvents();
    void updateRoomWarning(const FrameState&, const std::string& moment);
    void showEquipment(render::RenderScene&, const FrameState&, const patient::ContrastTable*,
                       const render::VisibleScreens&, const std::string& moment);
    void help(training::Difficulty);
    void showHints(HeadsetPanels&, const FrameState&, const std::array<render::View, 2>&);
    struct Drawn {
        render::RenderStats stats;
        std::span<const xr::ShownPanel> panels;
        // Excluded from the frame budget, so that intermittent work does not change the resolution.
        double equipment_ms = 0.0;
    };
    Drawn draw(xr::Frame&, const FrameState&, const patient::ContrastTable*, const std::string& moment);
    // Runs one frame. Returns true if it was rendered.
    bool show(const FrameState&, const patient::ContrastTable*, const std::string& moment);
    // Returns false if the frame must be tried again. Sets `over` when the runtime asks to end the session.
    bool tryFrame(const FrameState&, const patient::ContrastTable*, const std::string& moment, bool& over);

    const patient::Patient& patient;
    const PictureSettings settings;
    training::Difficulty difficulty;
    training::DifficultyRules rules;
    const OperativeField field;
    SceneMaker scenes;
    AlertWatch alerts;
    std::optional<GuidePanel> guide;  // only if the difficulty allows it
    const MockStage mock;
    LiveUpdates live;
    TipPredictor predictor;
    FrameTotals totals;
    Attention attention = Attention::absent;
    bool worn = true;
    RoomAlignment room;
    std::uint64_t warnings_seen = 0,
                  acts_before = 0;  // warningCount() and FrameState::rearm_acts at the last warning
    int undrawn = 0;                // consecutive frames without rendering
    bool settled = false;
    std::string lost_because;
    SteadyClock::time_point look_again{};
    MirrorChannels* window = nullptr;
    std::optional<TipOffset> newest_offset;
    std::unique_ptr<Headset> headset;  // null while no headset is found
};

FrameLoop::Impl::Impl(const patient::Patient& patient_in, const PictureSettings& settings_in,
                      const patient::PlannedPath& path)
    : patient(patient_in),
      settings(settings_in),
      difficulty(settings.config.difficulty),
      rules(settings.config.startRules()),
      field(settings.field),
      scenes(patient, path, field, sceneLook(settings.config), settings.press, rules),
      alerts(settings.press.tick_s),
      mock({settings.head_script, settings.config.fast, settings.config.folder}, scenes.stageFromPatient(),
           field),
      room(settings.colocation, scenes.stageFromPatient(), settings.config.seated) {
    if (rules.panel) guide.emplace(rules, controlsOf(settings.config.device), settings.press.tick_s);
    headset = std::make_unique<Headset>(patient, settings);
    totals.runtime = headset->session.runtimeName();
    totals.gpu = headset->gpu->name();
    headset->waitUntilRunning(kStartPatience);
    settle();
}

FrameLoop::Impl::~Impl() {
    if (settings.controllers) settings.controllers->attach(nullptr);
}

bool FrameLoop::Impl::found() {
    if (headset) return true;
    if (SteadyClock::now() < look_again) return false;
    try {
        headset = std::make_unique<Headset>(patient, settings);
        ++totals.headsets_found_again;
        printMessage("the headset is connected again");
    } catch (const std::runtime_error& e) {  // from the runtime, or a GPU that is not available again yet
        if (lost_because != e.what()) printMessage(fmt::format("still no headset: {}", e.what()));
        lost_because = e.what();
        if (!settings.config.fast) look_again = SteadyClock::now() + kLookAgain;
    }
    return headset != nullptr;
}

void FrameLoop::Impl::settle() {
    settled = true;
    const std::string refused =
        room.begin(headset->session.facts().space, headset->session.spaceGeneration());
    if (!refused.empty()) printMessage(refused);
    if (!settings.controllers) return;
    settings.controllers->attach(
        [&session = headset->session, side = int(controllerSide(settings.config.hand))](
            std::int64_t when_ns) -> std::optional<Pose> { return session.gripAt(side, when_ns); });
}

void FrameLoop::Impl::passController(const Pose& room_from_stage) {
    if (!settings.controllers) return;
    const int side = int(controllerSide(settings.config.hand));
    const auto keysOf = [](const xr::Hand& h) {
        return ControllerKeys{h.select, h.menu, h.squeeze, h.thumbstick[1]};
    };
    const xr::Hand hand = headset->session.hand(side);
    ControllerPort::Frame seen{room_from_stage, std::nullopt,
                               controllerButtons(keysOf(hand), keysOf(headset->session.hand(1 - side))),
                               hand.thumbstick};
    if (hand.stage_from_grip && hand.stage_from_aim)
        seen.grip_from_aim = hand.stage_from_grip->inverse() * *hand.stage_from_aim;
    settings.controllers->publish(seen);
    if (const auto v = settings.controllers->popVibration())
        headset->session.pulse(side, v->amplitude, v->duration_ns);
}

void FrameLoop::Impl::lose(const std::string& why) {
    printMessage("the headset was lost: " + why +
                 (live.on_attention ? "; the attempt continues while the program looks for it"
                                    : "; the program looks for it"));
    lost_because = why;
    if (settings.controllers) settings.controllers->attach(nullptr);
    // If the user had already looked away, the attempt stays paused.
    if (attention == Attention::focused) attention = Attention::absent;
    if (live.on_attention) live.on_attention(attention);
    worn = true;
    settled = false;
    undrawn = 0;
    if (!settings.config.fast) look_again = SteadyClock::now() + kLookAgain;
    totals.validation_messages += headset->gpu->validationMessages();
    totals.equipment += headset->equipment_pictures->totals();
    headset.reset();
}

// Replaces the state with a newer one, because xrBeginFrame may have blocked for a long time. A capture keeps
// its state.
FrameState FrameLoop::Impl::upToDate(const FrameState& seen, const std::string& moment) {
    if (!live.tips) return seen;
    FrameState now = seen;
    if (moment.empty()) live.refresh(now);
    predictor.add(*live.tips);
    while (const auto offset = predictor.measured()) {
        newest_offset = *offset;
        if (offset->frame < totals.times.size()) totals.times[offset->frame].tip = *offset;
    }
    return now;
}

// Predicts the tool pose at the display time. Needs a runtime whose time can be converted to the loop's
// clock.
haptics::TickOutput FrameLoop::Impl::predictTick(const xr::Frame& frame, const haptics::TickOutput& tick) {
    const auto display_ns = headset->session.monotonic_ns(frame.predicted_display_time_ns);
    if (!live.tips || !display_ns) return tick;
    const haptics::TickOutput drawn = predictor.at(tick, *display_ns);
    if (totals.times.size() < kMaxFrameTimes) predictor.drew(totals.times.size(), *display_ns, drawn);
    return drawn;
}

// Renders the equipment screens that are visible. A capture renders and saves both.
void FrameLoop::Impl::showEquipment(render::RenderScene& scene, const FrameState& seen,
                                    const patient::ContrastTable* contrast,
                                    const render::VisibleScreens& screens, const std::string& moment) {
    const ImagingInput m = makeImagingInput(seen, scene, *headset->renderer, contrast,
                                            settings.press.tools.guide, settings.press.tick_s);
    const bool kept = !moment.empty();
    EquipmentPictures& pictures = *headset->equipment_pictures;
    pictures.show(m, {.ultrasound = kept || screens.ultrasound, .xray = kept || screens.xray});
    scene.ultrasound_screen = pictures.ultrasoundScreen();
    scene.xray_screen = pictures.xrayScreen();
    if (kept && !settings.config.folder.empty()) pictures.save(settings.config.folder, moment);
}

// Applies a difficulty set by the instructor.
void FrameLoop::Impl::help(training::Difficulty now) {
    if (now == difficulty) return;
    difficulty = now;
    rules = settings.config.difficulties[now];
    scenes.help(rules);
    guide.reset();
    if (rules.panel) guide.emplace(rules, controlsOf(settings.config.device), settings.press.tick_s);
}

// Adds alerts and guide panel as the difficulty allows. The notice is drawn later, on top of them.
void FrameLoop::Impl::showHints(HeadsetPanels& panels, const FrameState& seen,
                                const std::array<render::View, 2>& views) {
    if (rules.colours) panels.placeAlert(alerts.update(seen), views);
    if (guide) {
        const bool looked_at = panels.sees(scenes.stageFromPatient() * field.entry_m, headPose(views));
        const std::uint64_t before = guide->revision();
        guide->update(seen, looked_at);
        totals.panels_drawn += guide->revision() - before;
        if (looked_at) panels.placeGuide(*guide);
        totals.unseen_panels += !looked_at;
    }
}

// Draws the eye images and the panels of a frame that the runtime shows.
FrameLoop::Impl::Drawn FrameLoop::Impl::draw(xr::Frame& frame, const FrameState& seen,
                                             const patient::ContrastTable* contrast,
                                             const std::string& moment) {
    xr::Session& session = headset->session;
    const Pose& room_from_stage = room.roomFromStage();
    Drawn drawn;
    if (window && !headset->mirror) headset->mirror.emplace(*window, *headset->gpu, settings.press.tick_s);
    const render::StereoTarget target{frame.image, session.colourFormat(), session.width(), session.height(),
                                      frame.depth_image};
    headset->adaptToBudget(frame, settings.config.budget_ms);
    FrameState predicted = seen;
    if (moment.empty()) predicted.tick = predictTick(frame, seen.tick);
    render::RenderScene scene = scenes.makeScene(predicted);
    scene.room.real = session.facts().blend_mode != "opaque";
    scene.room.shell = !scene.room.real;
    const auto equipment_begin = SteadyClock::now();
    const std::array<render::View, 2> expected = eyeViews(frame, room_from_stage);
    if (settings.listener_pose) settings.listener_pose->store(headPose(expected));
    const render::VisibleScreens screens = headset->renderer->visibleScreens(scene, expected);
    const render::ScreenPlaces places = headset->renderer->screenPlaces(scene);
    showEquipment(scene, seen, contrast, headset->mirror ? headset->mirror->screens(screens) : screens,
                  moment);
    HeadsetPanels& panels = headset->panelsFor(frame);
    // In passthrough, screens beneath the eye images would hide the real room.
    panels.placeScreens(scene, places, scene.room.real ? render::VisibleScreens{} : screens);
    showHints(panels, seen, expected);
    panels.placeNotice(room.warning() != RoomWarning::none ? makeNotice(room.warning(), settings.rearm_act)
                                                           : makeNotice(seen, attention, settings.rearm_act,
                                                                        controlsOf(settings.config.device)),
                       headPose(expected));
    drawn.equipment_ms = msSince(equipment_begin);
    drawn.panels = panels.shown(room_from_stage.inverse());
    session.lateUpdate(frame);
    const std::array<render::View, 2> views = eyeViews(frame, room_from_stage);
    drawn.stats = headset->renderer->draw(scene, views, target);
    addTo(totals.sum, drawn.stats);
    if (headset->mirror) headset->mirror->copyEye(target, views, places, scene.monitor_screen);
    if (!moment.empty()) session.markCapture(moment);
    ++totals.rendered;
    if (!totals.first) totals.first = firstPicture(*headset->gpu);
    return drawn;
}

bool FrameLoop::Impl::show(const FrameState& given, const patient::ContrastTable* contrast,
                           const std::string& moment) {
    xr::Session& session = headset->session;
    xr::Frame frame = session.beginFrame();
    const FrameState seen = upToDate(given, moment);
    help(seen.difficulty.value_or(settings.config.difficulty));
    const auto begin = SteadyClock::now();
    ++totals.frames;
    room.advance(frame.predicted_display_time_ns);
    if (frame.should_render) room.setEyeHeight(frame.views[0].stage_from_eye.position_m.y);
    passController(room.roomFromStage());
    updateRoomWarning(seen, moment);
    undrawn = frame.should_render ? 0 : undrawn + 1;
    const Drawn drawn = frame.should_render ? draw(frame, seen, contrast, moment) : Drawn{};
    session.endFrame(frame, drawn.panels);
    const std::uint64_t tick = seen.tick.tick;
    if (!frame.should_render && headset->mirror)
        publishState(*window, {seen, settings.press.tick_s, {tick}, std::nullopt, attention, true});
    if (!frame.should_render) return false;
    const render::RenderStats& stats = drawn.stats;
    const double took_ms = msSince(begin);
    if (headset->governor)
        headset->governor->reportFrame(stats.volume_ms,
                                       std::max(0.0, took_ms - drawn.equipment_ms - stats.volume_ms),
                                       stats.layer_scale);
    const FrameTime time{tick,
                         took_ms,
                         stats.opaque_ms,
                         stats.volume_ms,
                         stats.layer_scale,
                         std::nullopt,
                         isLate(session, frame)};
    if (totals.times.size() < kMaxFrameTimes) totals.times.push_back(time);
    if (headset->mirror)
        headset->mirror->publish(seen, *headset->equipment_pictures, time, attention,
                                 newest_offset ? std::optional(newest_offset->distance_m) : std::nullopt);
    return true;
}

void FrameLoop::Impl::pollSessionEvents() {
    const xr::SessionEvents events = headset->session.popEvents();
    worn = events.worn.value_or(worn);
    for (const xr::SpaceChange& change : events.spaces)
        room.onChange(change.at_ns,
                      change.pose_valid ? std::optional(change.previous_from_new) : std::nullopt);
    for (int eye = 0; eye < 2; ++eye)
        if (events.hidden_area_changed[std::size_t(eye)]) headset->updateHiddenArea(eye);
}

// While there is a room warning, there is no force. The user confirms the room by re-arming. Captures are
// ignored here, because they show the past.
void FrameLoop::Impl::updateRoomWarning(const FrameState& seen, const std::string& moment) {
    if (!moment.empty() || room.warning() == RoomWarning::none) return;
    if (room.warningCount() != warnings_seen) {
        warnings_seen = room.warningCount();
        acts_before = seen.rearm_acts;
        const Notice notice = makeNotice(room.warning(), settings.rearm_act);
        std::string text = notice.title + ":";
        for (const std::string& line : notice.lines)
            text += " " + line;
        printMessage(text);
    } else if (seen.rearm_acts > acts_before) {
        room.confirm();
    }
}

bool FrameLoop::Impl::tryFrame(const FrameState& seen, const patient::ContrastTable* contrast,
                               const std::string& moment, bool& over) {
    const bool waits = !settings.config.fast;
    try {
        const xr::SessionPhase phase = headset->session.poll();
        over = phase == xr::SessionPhase::exiting;
        if (over) {
            attention = Attention::absent;
            if (live.on_attention) live.on_attention(attention);
            return true;
        }
        if (phase == xr::SessionPhase::lossPending) {
            lose("the OpenXR runtime ended the session");
            return true;
        }
        pollSessionEvents();
        const bool looks = worn && phase == xr::SessionPhase::focused && undrawn < kBlindFrames;
        attention = attentionAfter(attention, looks);
        if (headset->session.running()) {
            if (!settled) settle();
            return show(seen, contrast, moment);
        }
    } catch (const xr::XrError& e) {
        lose(e.what());
        return true;
    }
    if (waits) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return false;
}

FrameLoop::FrameLoop(const patient::Patient& patient, const PictureSettings& settings,
                     const patient::PlannedPath& path) {
    // Silence the loader. Our own error message contains the same information.
    setenv("XR_LOADER_DEBUG", "none", 0);
    impl_ = std::make_unique<Impl>(patient, settings, path);
}

FrameLoop::~FrameLoop() = default;

bool FrameLoop::frame(const FrameState& seen, const patient::ContrastTable* contrast,
                      const std::string& moment) {
    Impl& loop = *impl_;
    const std::uint64_t rendered = loop.totals.rendered;
    if (!loop.found() && !loop.settings.config.fast)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (loop.window && !loop.headset)
        publishState(
            *loop.window,
            {seen, loop.settings.press.tick_s, {seen.tick.tick}, std::nullopt, loop.attention, false});
    const int tries = moment.empty() ? 1 : kMomentTries;
    bool over = false;
    for (int tried = 0; tried < tries && loop.headset; ++tried)
        if (loop.tryFrame(seen, contrast, moment, over)) break;
    if (!moment.empty() && !over && loop.totals.rendered == rendered)
        printMessage("no picture of capture \"" + moment + "\": the runtime shows no frames");
    return !over;
}

void FrameLoop::follow(LiveUpdates live) {
    impl_->live = std::move(live);
}

void FrameLoop::mirrorTo(MirrorChannels& window) {
    impl_->window = &window;
}

Attention FrameLoop::attention() const {
    const Impl& loop = *impl_;
    if (loop.room.warning() != RoomWarning::none && loop.attention == Attention::focused)
        return Attention::absent;
    return loop.attention;
}

FrameTotals FrameLoop::totals() const {
    FrameTotals totals = impl_->totals;
    if (const Headset* headset = impl_->headset.get()) {
        totals.validation_messages += headset->gpu->validationMessages();
        totals.equipment += headset->equipment_pictures->totals();
    }
    return totals;
}

}  // namespace stylet::trainer
