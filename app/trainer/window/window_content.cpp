#include "app/trainer/window/window_content.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <span>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/window/screens_beneath.h"

namespace stylet::trainer {
namespace {

constexpr report::Colour kBackground{0.075, 0.088, 0.10}, kWindowBlack{0.0, 0.0, 0.0},
    kBar{0.115, 0.135, 0.155}, kWindowQuiet{0.55, 0.61, 0.65}, kWindowWords{0.88, 0.91, 0.93},
    kLit{0.98, 0.78, 0.25};
constexpr std::array<float, 3> kClear{0.006f, 0.008f, 0.01f};
// Tool motion per key press (with Shift a quarter of it) and per step of the wheel, forward into the body.
constexpr double kKey_m = 0.002, kKey_rad = 0.035, kWheel_m = 0.001, kFiner = 0.25;
constexpr double kAlertStripe_px = 12.0;
constexpr int kAlertEdge = 28;         // shorter edge of the pane divided by the width of the alert's border
constexpr double kNoticeWidth = 0.48;  // largest width as a fraction of its pane
constexpr int kBarText = 230;          // width of the text beside a replay's bar, in pixels
constexpr double kDragTurn_rad = 1.5;  // rotation for a drag over the picture's height
constexpr auto kMetricsEvery = std::chrono::milliseconds(100),
               kMetricsProcessor = std::chrono::milliseconds(250),
               kSlicesEvery = std::chrono::milliseconds(120),
               kSlicesProcessor = std::chrono::milliseconds(400);
constexpr std::int64_t kEvery_ns = 15'000'000, kProcessorEvery_ns = 95'000'000;
// Of the equipment's pictures in the overview; shorter than kStale_s.
constexpr std::int64_t kScreensEvery_ns = 100'000'000, kProcessorScreensEvery_ns = 250'000'000;
constexpr double kStale_s = 0.5;
constexpr std::uint64_t kPresentPatience_ns = 50'000'000;
constexpr double kKeyText_px = 13.0, kKeysLeft_px = 12.0, kBetweenKeys_px = 14.0, kBetweenViews_px = 18.0;

double secondsSince(std::int64_t since_ns) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    return 1e-9 * double(now - since_ns);
}

report::TextStyle keyStyle(const report::Colour& colour, bool bold, double size = kKeyText_px) {
    return {size, colour, report::Align::left, bold};
}

}  // namespace

std::string screenCaption(WindowView view, const training::Equipment& equipment,
                          std::optional<double> age_s) {
    if (!age_s) return std::string(nameOf(view));
    if (*age_s >= kStale_s) return fmt::format("{} \u00b7 drawn {} s ago", nameOf(view), std::lround(*age_s));
    if (view == WindowView::xray)
        return fmt::format("{} \u00b7 {}", nameOf(view), equipment.xray.pedal ? "live" : "last image held");
    return fmt::format("{} \u00b7 {}", nameOf(view), equipment.ultrasound.freeze ? "frozen" : "live");
}

std::string missingPictureText(WindowView view, const training::Equipment& equipment) {
    if (view != WindowView::xray) return "the probe has not touched yet";
    return equipment.xray.pulses == 0 ? "the pedal has not been pressed yet" : "preparing \u2026";
}

WindowContent::WindowContent(const patient::Patient& patient, const patient::PlannedPath& path,
                             const MirrorSettings& settings, MirrorChannels& channels, render::Gpu& gpu,
                             render::Presenter& presenter)
    : patient_(&patient),
      path_(path),
      field_(settings.pictures.field),
      stage_from_patient_(stageFromPatient(patient, field_)),
      settings_(settings),
      rules_(settings.pictures.config.startRules()),
      channels_(&channels),
      gpu_(&gpu),
      presenter_(&presenter),
      slices_(patient),
      alerts_(settings.pictures.press.tick_s),
      keys_(settings.pictures.window) {}

// What the camera of an instructor's mirror shows: everything, whatever the trainee may see. The place of the
// prompt is shown only if there is a prompt.
training::DifficultyRules WindowContent::instructorsRules() const {
    return {.next_step = rules_.next_step, .path = true, .colours = rules_.colours, .open_look = true};
}

bool WindowContent::offered(WindowView view) const {
    if (view == WindowView::guide) return rules_.panel;
    if (view == WindowView::slices && settings_.desktop && !isReplay()) return rules_.slices;
    return !settings_.desktop || view != WindowView::rightEye;
}

const Pane* WindowContent::findPane(WindowView view) const {
    for (const Pane& pane : layout_.panes)
        if (pane.shows == view) return &pane;
    return nullptr;
}

void WindowContent::select(WindowView view) {
    if (!offered(view)) return;
    view_ = view;
    if (view <= WindowView::camera) main_ = view;
    stale_ = true;
}

void WindowContent::updateKeyRows() {
    WindowKeys::HelpRows help = keys_.rows(rules_);
    const std::array<std::uint32_t, 3> fits{width_, height_, help_page_};
    if (help == help_ && key_rows_fit_ == fits) return;
    help_ = std::move(help), key_rows_fit_ = fits;
    const auto entry_px = [this](const WindowKeys::Help& entry) {
        return measure_.textWidth(entry.key + " ", keyStyle(kWindowWords, true)) +
               measure_.textWidth(entry.what, keyStyle(kWindowQuiet, false)) + kBetweenKeys_px;
    };
    const int max_rows = std::max(1, maxKeyRows(int(height_)) - otherKeyRows());
    key_rows_ = fitRows(help_, width_ - 2.0 * kKeysLeft_px, max_rows, int(help_page_), entry_px);
}

void WindowContent::arrange() {
    updateKeyRows();
    const LayoutSettings settings{.key_rows = otherKeyRows() + int(key_rows_.size()),
                                  .slices = settings_.desktop && offered(WindowView::slices),
                                  .guide = settings_.desktop && rules_.panel};
    layout_ = computeLayout(view_, main_, int(width_), int(height_), settings);
    if (!rules_.colours || layout_.panes.empty()) return;
    Rect& area = layout_.panes.front().area;
    frame_ = area;
    const int edge = std::min(area.width, area.height) / kAlertEdge;
    area = {area.x + edge, area.y + edge, std::max(1, area.width - 2 * edge),
            std::max(1, area.height - 2 * edge)};
}

// True if this window may show what the difficulty hides from the trainee: either another person looks at the
// window, or nothing is hidden.
bool WindowContent::showsHidden() const {
    return !settings_.desktop || rules_.panel || isReplay();
}

void WindowContent::handleKey(const KeyPress& press) {
    const char key = press.key;
    if (keys_.isTyping()) return keys_.press(press);
    if (key >= '1' && key < '1' + kWindowViews) select(WindowView(key - '1'));
    if (key == kKeyTab) {
        int next = int(view_);
        do
            next = (next + (press.shift ? kWindowViews - 1 : 1)) % kWindowViews;
        while (!offered(WindowView(next)));
        select(WindowView(next));
    }
    if (key == 'r') orbit_.reset();
    if (key == kMoreKeys) ++help_page_;
    keys_.press(press);
    if (hasToolInput()) moveToolBy(press);
}

// Converts a motion in the operator's view to a motion of the tool. `right` and `up` are metres at the tool.
// With `turns` they are radians about the tip, and the far end of the tool moves in that direction.
MouseMove WindowContent::inOperatorsView(double right, double up, bool turns) const {
    const Pose patient_from_eye =
        stage_from_patient_.inverse() * operatorView(stage_from_patient_, field_, 1.0).stage_from_eye;
    MouseMove move;
    (turns ? move.turned_rad : move.moved_m) =
        patient_from_eye.direction(turns ? Vec3(-up, right, 0.0) : Vec3(right, up, 0.0));
    return move;
}

void WindowContent::moveToolBy(const KeyPress& press) {
    const double share = press.shift ? kFiner : 1.0;
    MouseMove move;
    const double right = double(press.key == kKeyRight) - double(press.key == kKeyLeft),
                 up = double(press.key == kKeyUp) - double(press.key == kKeyDown),
                 deeper = double(press.key == kKeyPageDown) - double(press.key == kKeyPageUp),
                 rolled = double(press.key == 'q') - double(press.key == 'e');
    if (press.key == kKeyHome && rules_.home)
        move.home = true;
    else if (right != 0.0 || up != 0.0)
        move = press.shift ? inOperatorsView(kKey_rad * right, kKey_rad * up, true)
                           : inOperatorsView(kKey_m * right, kKey_m * up, false);
    else if (deeper != 0.0)
        move.deeper_m = share * kKey_m * deeper;
    else if (rolled != 0.0)
        move.rolled_rad = share * kKey_rad * rolled;
    else
        return;
    settings_.pictures.window->move(move);
}

// Converts a drag to a motion of the tool, so that the tool stays under the pointer.
std::optional<MouseMove> WindowContent::dragMotion(const Drag& drag) const {
    const double right_px = drag.right * double(height_), up_px = drag.up * double(height_);
    if (const Pane* slices = findPane(WindowView::slices);
        slices && slices->area.holds(drag.from_x, drag.from_y)) {
        const auto spot = slices_.at(drag.from_x - slices->area.x, drag.from_y - slices->area.y);
        if (!spot || drag.pans) return std::nullopt;
        return MouseMove{.moved_m = spot->m_per_pixel * (right_px * spot->right - up_px * spot->down)};
    }
    const Pane* eye = findPane(WindowView::leftEye);
    if (!eye || !settings_.desktop || !state_known_ || !eye->area.holds(drag.from_x, drag.from_y))
        return std::nullopt;
    const double right = right_px / eye->area.height, up = up_px / eye->area.height;
    if (drag.pans) return inOperatorsView(kDragTurn_rad * right, kDragTurn_rad * up, true);
    const render::View view = operatorView(stage_from_patient_, field_, 1.0);
    const Vec3 tip_m = activeToolPose(channels_->state.front().seen.tick).position_m;
    const double away_m = -(view.stage_from_eye.inverse() * (stage_from_patient_ * tip_m)).z;
    const double tall_m = 2.0 * away_m * std::tan(double(view.angle_up));
    return inOperatorsView(tall_m * right, tall_m * up, false);
}

// Area of a replay's bar, below the key help.
Rect WindowContent::barRect() const {
    const Rect& keys = layout_.keys;
    return {keys.x + 12, keys.y + keys.height - kKeyRowHeight, std::max(1, keys.width - 24 - kBarText),
            kKeyRowHeight - 6};
}

void WindowContent::scrub(const std::vector<Drag>& drags) {
    const Rect bar = barRect();
    for (const Drag& drag : drags) {
        if (layout_.keys.height == 0 || !bar.holds(drag.from_x, drag.from_y)) continue;
        scrubbed_px_ = drag.begins ? drag.from_x : scrubbed_px_ + drag.right * double(height_);
        const double share = std::clamp((scrubbed_px_ - bar.x) / bar.width, 0.0, 1.0);
        settings_.pictures.window->pushLine("stop");
        settings_.pictures.window->pushLine("seek " + std::to_string(share));
    }
}

std::string WindowContent::playbackText() const {
    if (!isReplay()) return {};
    return fmt::format("{:.1f} of {:.1f} s  \u00d7 {:g}{}", playback_.at_s, playback_.length_s,
                       playback_.speed, playback_.plays ? "" : "  stopped");
}

// Answer to the newest command. A user who is typing sees what is typed instead.
std::string WindowContent::answerText() const {
    return state_known_ && !keys_.isTyping() ? channels_->state.front().seen.answer : std::string();
}

void WindowContent::drawBar(report::Canvas& c) const {
    if (!isReplay() || layout_.keys.height == 0) return;
    const Rect bar = barRect();
    const double share = playback_.length_s > 0.0 ? playback_.at_s / playback_.length_s : 0.0;
    c.rectangle(bar.x, bar.y, bar.width, bar.height, kBar);
    c.rectangle(bar.x, bar.y, share * bar.width, bar.height, kLit.faded(0.55));
    c.rectangle(bar.x + share * bar.width - 1.5, bar.y - 2.0, 3.0, bar.height + 4.0, kLit);
    c.text({bar.x + bar.width + 14.0, bar.y + 13.0}, playbackText(), {13, kWindowWords});
}

void WindowContent::moveTool(const WindowEvents& events) {
    if (!hasToolInput()) return;
    for (const Drag& drag : events.drags)
        if (const auto move = dragMotion(drag)) settings_.pictures.window->move(*move);
    if (events.wheel != 0.0 && !findPane(WindowView::camera))
        settings_.pictures.window->move({.deeper_m = kWheel_m * events.wheel});
}

bool WindowContent::handleEvents(const WindowEvents& events) {
    for (const KeyPress& key : events.keys)
        handleKey(key);
    const bool same = events.width == width_ && events.height == height_;
    stale_ |= events.exposed || !same;
    width_ = events.width, height_ = events.height;
    arrange();
    if (isReplay()) scrub(events.drags);
    moveTool(events);
    const Pane* camera = findPane(WindowView::camera);
    if (!camera) return same;
    if (!orbit_) orbit_ = startOrbit(stage_from_patient_, field_), camera_stale_ = true;
    for (const Drag& drag : events.drags) {
        if (!camera->area.holds(drag.from_x, drag.from_y)) continue;
        const double share = double(height_) / camera->area.height;
        (drag.pans ? pan : turn)(*orbit_, share * drag.right, share * drag.up);
        camera_stale_ = true;
    }
    if (events.wheel != 0.0) zoom(*orbit_, events.wheel), camera_stale_ = true;
    return same;
}

void WindowContent::publishRequests() {
    MirrorRequests requests;
    const Pane* eye = findPane(main_ == WindowView::rightEye ? WindowView::rightEye : WindowView::leftEye);
    const Pane* camera = findPane(WindowView::camera);
    requests.every_ns = gpu_->isSoftware() ? kProcessorEvery_ns : kEvery_ns;
    if (width_ > 0) {
        requests.ultrasound = findPane(WindowView::ultrasound) != nullptr;
        requests.xray = findPane(WindowView::xray) != nullptr;
        if (view_ == WindowView::overview)
            requests.screens_every_ns = gpu_->isSoftware() ? kProcessorScreensEvery_ns : kScreensEvery_ns;
        const Pane* room = settings_.desktop && camera ? camera : eye;
        if (eye && !settings_.desktop) requests.eye = eye->shows == WindowView::rightEye ? 1 : 0;
        if (room) {
            requests.width = std::uint32_t(room->area.width),
            requests.height = std::uint32_t(room->area.height);
            requests.max_pixels = std::max(requests.width, requests.height);
            if (room == camera) requests.camera = orbit_;
        }
    }
    channels_->requests.publish(requests);
}

bool WindowContent::readPictures() {
    bool fresh = false;
    if (keys_.isFrozen()) return false;
    if (isReplay()) playback_ = settings_.pictures.window->playback();
    const auto upload = [&](Picture id, const render::Image& image) {
        presenter_->setPicture(id, image.width, image.height, image.rgba);
        shown_[id] = {int(image.width), int(image.height)};
        fresh = true;
    };
    const auto machine = [&](Picture id, Latest<ScreenUpdate>& channel, auto& uploaded) {
        if (!channel.update()) return;
        const ScreenUpdate& given = channel.front();
        if (std::pair(given.maker, given.revision) == uploaded) return;
        uploaded = {given.maker, given.revision};
        upload(id, given.image);
    };
    machine(kUltrasound, channels_->ultrasound, ultrasound_uploaded_);
    machine(kXray, channels_->xray, xray_uploaded_);
    channels_->monitor.update();
    if (channels_->eye.update()) {
        EyeUpdate& eye = channels_->eye.front();
        showBeneath(eye, {&channels_->ultrasound.front().image, &channels_->xray.front().image,
                          &channels_->monitor.front().image});
        upload(kEye, eye.image);
        eye_given_ = eye.eye;
    }
    if (channels_->state.update()) {
        state_known_ = camera_stale_ = metrics_pane_.stale = slices_pane_.stale = true;
        const FrameState& seen = channels_->state.front().seen;
        keys_.setState(seen.paused_by_instructor, seen.lights_out, seen.difficulty);
        keys_.setCourse(seen.progress.course);
        if (seen.difficulty) help(*seen.difficulty);
        updateHints(seen);
    }
    FrameSample sample;
    while (channels_->samples.pop(sample))
        metrics_.add(sample);
    return fresh;
}

// Applies a new difficulty.
void WindowContent::help(training::Difficulty difficulty) {
    if (difficulty == difficulty_) return;
    difficulty_ = difficulty;
    rules_ = settings_.pictures.config.difficulties[difficulty];
    guide_.reset();
    alert_ = {};
    if (camera_) camera_->help(instructorsRules());
    if (!offered(view_)) view_ = WindowView::overview;
    stale_ = true;
}

// Updates the alert, the guide panel and the notice to those that the trainee sees at a tick.
void WindowContent::updateHints(const FrameState& seen) {
    const bool back = isReplay() && seen.tick.tick < tick_;
    tick_ = seen.tick.tick;
    if (back) metrics_ = {}, alerts_ = AlertWatch(settings_.pictures.press.tick_s);
    if (rules_.colours) alert_ = alerts_.update(seen);
    if (rules_.panel) {
        if (!guide_)
            guide_.emplace(rules_, controlsOf(settings_.pictures.config.device),
                           settings_.pictures.press.tick_s),
                guide_shown_ = 0;
        const Pane* pane = findPane(WindowView::guide);
        if (pane) {
            const auto [width, height] = GuidePanel::sizeIn(pane->area.width, pane->area.height);
            if (shown_[kGuide].width != width || shown_[kGuide].height != height || guide_shown_ == 0)
                guide_->resize(width, height);
            shown_[kGuide] = {width, height};
        }
        guide_->update(seen, pane != nullptr);
    }
    const std::optional<Notice> notice =
        settings_.desktop && !isReplay()
            ? makeNotice(seen, channels_->state.front().attention, settings_.pictures.rearm_act,
                         controlsOf(settings_.pictures.config.device))
            : std::nullopt;
    stale_ |= noticed_ != notice.has_value();
    noticed_ = notice.has_value();
    if (notice) notice_.show(*notice);
}

bool WindowContent::drawGuide() {
    if (!guide_ || !findPane(WindowView::guide) || guide_->revision() == guide_shown_) return false;
    guide_shown_ = guide_->revision();
    presenter_->setPicture(kGuide, std::uint32_t(shown_[kGuide].width), std::uint32_t(shown_[kGuide].height),
                           guide_->rgba());
    return true;
}

bool WindowContent::drawNotice() {
    if (!noticed_ || notice_.revision() == notice_shown_) return false;
    notice_shown_ = notice_.revision();
    const auto height = std::uint32_t(notice_.filledHeight());
    presenter_->setPicture(kNotice, NoticePanel::kWidth, height,
                           std::span(notice_.rgba()).first(std::size_t(4) * NoticePanel::kWidth * height));
    return true;
}

// Places the notice at the bottom of the trainee's view. Its empty rows would only hide more of the patient.
void WindowContent::placeNotice() {
    if (!noticed_ || notice_shown_ == 0 || layout_.panes.empty()) return;
    const Rect& area = layout_.panes.front().area;
    const int widest = std::max(1, (area.height - 2 * kGap) * NoticePanel::kWidth / notice_.filledHeight());
    const int width = std::min({NoticePanel::kWidth, int(kNoticeWidth * area.width), widest}),
              height = width * notice_.filledHeight() / NoticePanel::kWidth;
    placed_.push_back({kNotice, area.x + (area.width - width) / 2, area.y + area.height - height - kGap,
                       std::uint32_t(width), std::uint32_t(height)});
}

bool WindowContent::drawCamera() {
    const Pane* pane = findPane(WindowView::camera);
    if (!pane || settings_.desktop || camera_failed_ || !state_known_ || !camera_stale_) return false;
    try {
        if (!camera_) camera_.emplace(*gpu_, *patient_, path_, settings_.pictures, instructorsRules());
        render::RenderScene scene = camera_->makeScene(channels_->state.front().seen);
        const auto screen = [](const ScreenUpdate& given) {
            return render::ScreenPicture{int(given.image.width), int(given.image.height),
                                         given.image.rgba.data(), given.revision + (given.maker << 32)};
        };
        scene.ultrasound_screen = screen(channels_->ultrasound.front());
        scene.xray_screen = screen(channels_->xray.front());
        const auto [width, height] =
            camera_->sizeFor(std::uint32_t(pane->area.width), std::uint32_t(pane->area.height));
        const render::Image& image =
            camera_->draw(scene, camera_->view(orbit_, double(width) / height), width, height);
        presenter_->setPicture(kCamera, image.width, image.height, image.rgba);
        shown_[kCamera] = {int(image.width), int(image.height)};
    } catch (const std::runtime_error& e) {
        printMessage(fmt::format("no free camera: {}", e.what()));
        camera_failed_ = true;
        camera_.reset();
    }
    camera_stale_ = false;
    return true;
}

// Draws a canvas as large as the view's pane. Draws it if its size has changed. If it is stale, draws it at
// most once per `period`. Returns true if it was drawn.
template <typename Draw>
bool WindowContent::drawPane(WindowView view, PaneCanvas& pane_canvas, std::chrono::milliseconds period,
                             const Draw& draw) {
    const Pane* pane = findPane(view);
    if (!pane || !state_known_) return false;
    const Rect& area = pane->area;
    Shown& shown = shown_[pictureId(view)];
    const bool sized = shown.width == area.width && shown.height == area.height;
    if (sized && (!pane_canvas.stale || Clock::now() < pane_canvas.drawn + period)) return false;
    if (!sized) pane_canvas.canvas = std::make_unique<report::Canvas>(area.width, area.height, kWindowBlack);
    shown = {area.width, area.height};
    draw(*pane_canvas.canvas, area.width, area.height);
    pane_canvas.canvas->pixels(pixels_);
    presenter_->setPicture(pictureId(view), std::uint32_t(area.width), std::uint32_t(area.height), pixels_);
    pane_canvas.drawn = Clock::now(), pane_canvas.stale = false;
    return true;
}

bool WindowContent::drawMetrics() {
    return drawPane(WindowView::metrics, metrics_pane_,
                    gpu_->isSoftware() ? kMetricsProcessor : kMetricsEvery,
                    [&](report::Canvas& canvas, int width, int height) {
                        metrics_.draw(canvas, width, height, channels_->state.front(), showsHidden());
                    });
}

bool WindowContent::drawSlices() {
    return drawPane(WindowView::slices, slices_pane_, gpu_->isSoftware() ? kSlicesProcessor : kSlicesEvery,
                    [&](report::Canvas& canvas, int width, int height) {
                        slices_.draw(canvas, width, height, channels_->state.front().seen);
                    });
}

std::string WindowContent::makeCaption(WindowView view) const {
    const auto screen = [&](const ScreenUpdate& given) {
        return screenCaption(
            view, channels_->state.front().seen.equipment,
            shown_[pictureId(view)].width > 0 ? std::optional(secondsSince(given.shown_ns)) : std::nullopt);
    };
    switch (view) {
        case WindowView::leftEye:
            return settings_.desktop ? "operator's place" : "left eye \u00b7 what the trainee sees";
        case WindowView::rightEye:
            return "right eye \u00b7 what the trainee sees";
        case WindowView::camera:
            return "free camera \u00b7 drag: turn, right button or Shift: move, wheel: nearer, R: back";
        case WindowView::slices:
            return "CT slices at the tool tip (breathing)";
        case WindowView::ultrasound:
            return screen(channels_->ultrasound.front());
        case WindowView::xray:
            return screen(channels_->xray.front());
        case WindowView::guide:
            return settings_.desktop ? "guide" : "guide \u00b7 what the trainee reads";
        default:
            return std::string(nameOf(view));
    }
}

std::string WindowContent::emptyText(WindowView view) const {
    switch (view) {
        case WindowView::ultrasound:
        case WindowView::xray:
            if (state_known_) return missingPictureText(view, channels_->state.front().seen.equipment);
            break;
        case WindowView::camera:
            return camera_failed_ ? "no free camera on this GPU" : "preparing \u2026";
        default:
            break;
    }
    return "waiting for the first frame \u2026";
}

WindowContent::Picture WindowContent::pictureId(WindowView view) const {
    if (view == WindowView::camera && settings_.desktop) return kEye;
    constexpr std::array<Picture, kWindowViews> kPictures{kEye,     kEye, kCamera, kUltrasound, kXray,
                                                          kMetrics, kEye, kSlices, kGuide};
    return kPictures[std::size_t(view)];
}

// Draws the parts of the window around the pictures: captions, keys, and texts in place of missing pictures.
bool WindowContent::drawChrome() {
    std::string key = fmt::format("{}x{}{}", width_, height_, nameOf(view_));
    for (const Pane& pane : layout_.panes)
        key +=
            makeCaption(pane.shows) + (shown_[pictureId(pane.shows)].width > 0 ? "+" : emptyText(pane.shows));
    for (const std::vector<WindowKeys::Help>& row : key_rows_)
        for (const WindowKeys::Help& help : row)
            key += help.key;
    key += keys_.state() + answerText() + playbackText() + (alert_ ? alertWord(*alert_) : "");
    if (key == chrome_key_) return false;
    chrome_key_ = key;
    const Shown size{int(width_), int(height_)};
    if (!chrome_ || shown_[kChrome].width != size.width || shown_[kChrome].height != size.height)
        chrome_ = std::make_unique<report::Canvas>(size.width, size.height, kBackground);
    shown_[kChrome] = size;
    report::Canvas& c = *chrome_;
    c.rectangle(0, 0, size.width, size.height, kBackground);
    for (const Pane& pane : layout_.panes) {
        const Rect &bar = pane.caption, &area = pane.area;
        c.rectangle(bar.x, bar.y, bar.width, bar.height, kBar);
        c.rectangle(area.x, area.y, area.width, area.height, kWindowBlack);
        c.clip(bar.x, bar.y, bar.width, bar.height);
        c.text({bar.x + 10.0, bar.y + 18.0}, makeCaption(pane.shows), {13, kWindowWords});
        c.unclip();
        if (shown_[pictureId(pane.shows)].width == 0)
            c.text({area.x + 0.5 * area.width, area.y + 0.5 * area.height}, emptyText(pane.shows),
                   {std::clamp(area.width / 34.0, 10.0, 16.0), kWindowQuiet, report::Align::centre});
    }
    drawAlert(c);
    drawKeys(c);
    drawBar(c);
    c.pixels(pixels_);
    presenter_->setPicture(kChrome, width_, height_, pixels_);
    return true;
}

// Draws the alert around the trainee's view and in its caption, so that the picture itself stays free.
void WindowContent::drawAlert(report::Canvas& c) const {
    if (!alert_ || layout_.panes.empty()) return;
    const Pane& pane = layout_.panes.front();
    const report::Colour colour = alertColour(*alert_);
    c.rectangle(frame_.x, frame_.y, frame_.width, frame_.height, colour);
    c.clip(frame_.x, frame_.y, frame_.width, frame_.height);
    drawAlertPattern(c, *alert_, width_, height_, kAlertStripe_px);
    c.unclip();
    c.rectangle(pane.area.x, pane.area.y, pane.area.width, pane.area.height, kWindowBlack);
    c.rectangle(pane.caption.x, pane.caption.y, pane.caption.width, pane.caption.height, colour);
    c.text({pane.caption.x + 0.5 * pane.caption.width, pane.caption.y + 19.0}, alertWord(*alert_),
           {16, {1.0, 1.0, 1.0}, report::Align::centre, true});
}

// Draws the keys of the views and the message to the user, then the other keys. A message that does not fit
// beside the views takes their place.
void WindowContent::drawKeys(report::Canvas& c) const {
    if (layout_.keys.height == 0) return;
    struct Word {
        std::string text;
        report::TextStyle style;
        double gap_px = 0.0;  // after it
    };
    using Words = std::vector<Word>;
    const double most_px = layout_.keys.width - 2.0 * kKeysLeft_px;
    double x = kKeysLeft_px, y = layout_.keys.y + 0.66 * kKeys;
    const auto widthOf = [&](const Words& words) {
        double sum_px = 0.0;
        for (const Word& word : words)
            sum_px += c.textWidth(word.text, word.style) + word.gap_px;
        return sum_px;
    };
    // Smaller, if they would not fit.
    const auto draw = [&](const Words& words) {
        const double scale = std::min(1.0, most_px / std::max(1.0, widthOf(words)));
        for (Word word : words) {
            word.style.size *= scale;
            c.text({x, y}, word.text, word.style);
            x += c.textWidth(word.text, word.style) + scale * word.gap_px;
        }
    };
    Words views, message;
    for (int i = 0; i < kWindowViews; ++i) {
        const WindowView view = WindowView(i);
        if (!offered(view)) continue;
        const bool now = view == view_;
        views.push_back({std::to_string(i + 1) + " ", keyStyle(now ? kLit : kWindowWords, true)});
        views.push_back(
            {settings_.desktop && view == WindowView::leftEye ? "operator" : std::string(nameOf(view)),
             keyStyle(now ? kLit : kWindowQuiet, now), kBetweenViews_px});
    }
    views.push_back({"Tab ", keyStyle(kWindowWords, true)});
    views.push_back({"next", keyStyle(kWindowQuiet, false), 2.0 * kBetweenKeys_px});
    if (const std::string state = keys_.state(); !state.empty())
        message.push_back({state, keyStyle(kLit, true), 2.0 * kBetweenKeys_px});
    if (const std::string answer = answerText(); !answer.empty())
        message.push_back({answer, keyStyle(kLit, false)});
    c.clip(0, layout_.keys.y, layout_.keys.width, layout_.keys.height);
    if (message.empty() || widthOf(views) + widthOf(message) <= most_px) draw(views);
    draw(message);
    for (const std::vector<WindowKeys::Help>& row : key_rows_) {
        x = kKeysLeft_px, y += kKeyRowHeight;
        Words entries;
        for (const WindowKeys::Help& help : row) {
            entries.push_back({help.key + " ", keyStyle(kWindowWords, true)});
            entries.push_back({help.what, keyStyle(kWindowQuiet, false), kBetweenKeys_px});
        }
        draw(entries);
    }
    c.unclip();
}

void WindowContent::place(Picture picture, WindowView view) {
    const Pane* pane = findPane(view);
    if (!pane || shown_[picture].width == 0) return;
    if (picture == kEye && !settings_.desktop && eye_given_ != (view == WindowView::rightEye ? 1 : 0)) return;
    const Rect r = fitted(pane->area, shown_[picture].width, shown_[picture].height);
    placed_.push_back({picture, r.x, r.y, std::uint32_t(r.width), std::uint32_t(r.height)});
}

bool WindowContent::update() {
    arrange();
    publishRequests();
    bool fresh = readPictures();
    if (width_ == 0 || height_ == 0) return false;
    fresh |= drawCamera();
    fresh |= drawMetrics();
    fresh |= drawSlices();
    fresh |= drawGuide();
    fresh |= drawNotice();
    fresh |= drawChrome();
    placed_.assign(1, {kChrome, 0, 0, width_, height_});
    for (const Pane& pane : layout_.panes)
        place(pictureId(pane.shows), pane.shows);
    placeNotice();
    stale_ |= fresh;
    return stale_;
}

bool WindowContent::present() {
    if (!presenter_->show(width_, height_, placed_, kClear, kPresentPatience_ns)) return false;
    stale_ = false;
    return true;
}

std::string WindowContent::title() const {
    const bool operator_view = settings_.desktop && view_ == WindowView::leftEye;
    return fmt::format("Stylet \u2013 {}", operator_view ? "operator's place" : nameOf(view_));
}

}  // namespace stylet::trainer
