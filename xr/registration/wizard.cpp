#include "xr/registration/wizard.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>

#include "xr/registration/places.h"

namespace stylet::xr::registration {
namespace {

constexpr double kUnseen_s = 0.3;  // a pose stream silent for this long counts as lost
constexpr double kTipLeast_s = 3.0, kTipMost_s = 20.0, kTryAgain_s = 0.25;
constexpr double kTipSd_m = 0.0007, kTipResidual_m = 0.004, kTipTurn_rad = 0.8;
constexpr double kTipFloor_m = 0.0003;
constexpr double kSweepMost_s = 60.0, kSweepTurn_rad = 0.7, kTooFast_m_per_s = 0.6;
constexpr int kSweepOctants = 7;
constexpr double kNear = 0.6;  // places within this fraction of half_m of a touched point count as touched
constexpr std::size_t kLeastSamples = 5;
constexpr std::size_t kMostPoses = 150;  // limit of poses examined per stream during recording

std::string filled(const char* format, double a, double b = 0.0) {
    std::array<char, 200> line{};
    std::snprintf(line.data(), line.size(), format, a, b);
    return line.data();
}

std::vector<Rigid> thinned(std::span<const Timed> stream) {
    std::vector<Rigid> poses;
    const std::size_t step = std::max<std::size_t>(1, stream.size() / kMostPoses);
    for (std::size_t i = 0; i < stream.size(); i += step)
        poses.push_back(stream[i].pose);
    return poses;
}

double turned_rad(std::span<const Rigid> poses) {
    double most = 0.0;
    Quat from = poses.empty() ? Quat(1.0, 0.0, 0.0, 0.0) : poses.front().rotation;
    for (int round = 0; round < 2; ++round) {
        Quat farthest = from;
        for (const Rigid& pose : poses)
            if (const double turn = angleBetween(from, pose.rotation); turn > most)
                most = turn, farthest = pose.rotation;
        from = farthest;
    }
    return most;
}

double speed_m_per_s(std::span<const Timed> stream) {
    if (stream.size() < 2) return 0.0;
    const Timed &last = stream.back(), *before = &stream.front();
    for (const Timed& s : stream)
        if (last.t_s - s.t_s >= 0.05) before = &s;
    const double dt_s = last.t_s - before->t_s;
    return dt_s > 0.0 ? glm::distance(last.pose.position_m, before->pose.position_m) / dt_s : 0.0;
}

}  // namespace

Wizard::Wizard(const WizardSettings& settings)
    : settings_(settings),
      device_s_(-1e9),
      tracked_s_(-1e9),
      places_(spreadPlaces(settings.cube, std::max(settings.points, 8))) {
    redo();
}

void Wizard::redo() {
    pairs_.clear();
    fit_.reset();
    verdict_ = {};
    tip_m_ = knownTip_m().value_or(Vec3(0.0));
    tip_sd_m_ = kTipFloor_m;
    enter(WizardStage::start);
}

std::optional<Vec3> Wizard::knownTip_m() const {
    return settings_.earlier ? settings_.earlier->grip_from_tip_m : settings_.grip_from_tip_m;
}

int Wizard::places() const {
    return settings_.earlier ? settings_.touches : settings_.points;
}

WizardStage Wizard::afterTip() const {
    return settings_.in_motion && !settings_.earlier ? WizardStage::sweep : WizardStage::places;
}

void Wizard::tell(std::string note, bool warns) {
    note_ = std::move(note), warns_ = warns;
}

void Wizard::enter(WizardStage stage, std::string note, bool warns) {
    stage_ = stage;
    recording_s_.reset();
    device_.clear(), tracked_.clear();
    tell(std::move(note), warns);
}

void Wizard::beginRecording(double now_s) {
    recording_s_ = tried_s_ = now_s;
    device_.clear(), tracked_.clear();
    tell("", false);
}

void Wizard::step(const WizardInput& in) {
    now_s_ = in.now_s;
    if (!in.device.empty())
        device_s_ = in.device.back().t_s, device_tip_m_ = in.device.back().pose.position_m;
    if (!in.tracked.empty()) tracked_s_ = in.tracked.back().t_s;
    if (recording_s_) {
        device_.insert(device_.end(), in.device.begin(), in.device.end());
        tracked_.insert(tracked_.end(), in.tracked.begin(), in.tracked.end());
    }
    switch (stage_) {
        case WizardStage::start:
            return start(in);
        case WizardStage::tip:
            return findTip(in);
        case WizardStage::places:
            return takePlace(in);
        case WizardStage::sweep:
            return takeSweep(in);
        case WizardStage::result:
            return showResult(in);
        case WizardStage::accepted:
            return;
    }
}

void Wizard::start(const WizardInput& in) {
    const bool device = now_s_ - device_s_ < kUnseen_s, tracked = now_s_ - tracked_s_ < kUnseen_s;
    if (!device || !tracked) {
        tell(!device ? "The haptic device is not ready." : "The headset does not see the controller.", true);
        return;
    }
    if (warns_) tell("", false);
    if (!in.press) return;
    enter(knownTip_m() ? afterTip() : WizardStage::tip);
}

// Pivot calibration: the controller's tip rests on the device's resting tip while the user rotates the
// controller.
void Wizard::findTip(const WizardInput& in) {
    if (!recording_s_) {
        if (in.press) beginRecording(now_s_);
        return;
    }
    const double since_s = now_s_ - *recording_s_;
    if (since_s < kTipLeast_s || now_s_ - tried_s_ < kTryAgain_s) return;
    tried_s_ = now_s_;
    const Answer<Pivot> pivot = calibratePivot(thinned(tracked_));
    if (pivot && pivot->turned_rad >= kTipTurn_rad && pivot->tip_sd_m <= kTipSd_m &&
        pivot->residual_m <= kTipResidual_m) {
        tip_m_ = pivot->grip_from_tip_m;
        tip_sd_m_ = std::max(kTipFloor_m, pivot->tip_sd_m);
        enter(afterTip(), filled("The controller's tip is %.0f mm from its grip, found to %.1f mm.",
                                 1e3 * glm::length(tip_m_), 1e3 * tip_sd_m_));
        return;
    }
    if (since_s < kTipMost_s) {
        tell(pivot ? "Turn it farther, to all sides." : pivot.why_not, false);
        return;
    }
    enter(WizardStage::tip,
          pivot ? filled("The tip slipped by %.1f mm: press and try again.", 1e3 * pivot->residual_m)
                : pivot.why_not,
          true);
}

FitSettings Wizard::fitSettings() const {
    FitSettings fit;
    fit.gimbal = settings_.senses_rotation;
    fit.tip = true;
    fit.tip_guess_m = tip_m_;
    fit.tip_sd_m = tip_sd_m_;
    fit.cube = settings_.cube;
    return fit;
}

void Wizard::takePlace(const WizardInput& in) {
    if (recording_s_) {
        if (now_s_ - *recording_s_ >= settings_.hold_s) finishPlace();
        return;
    }
    if (in.back && !pairs_.empty()) {
        pairs_.pop_back();
        tell("The last point was removed.", false);
    } else if (in.press) {
        beginRecording(now_s_);
    }
}

void Wizard::finishPlace() {
    const Answer<Held> device = meanPose(device_), tracked = meanPose(tracked_);
    const bool seen = device_.size() >= kLeastSamples && tracked_.size() >= kLeastSamples;
    enter(WizardStage::places);
    if (!seen || !device || !tracked)
        return tell(device_s_ < now_s_ - kUnseen_s ? "The device was not ready: press again."
                                                   : "The controller was not seen: press again.",
                    true);
    const double moved_m = std::max(device->spread_m, tracked->spread_m);
    if (moved_m > settings_.stillest_m)
        return tell(filled("It moved by %.0f mm: hold still and press again.", 1e3 * moved_m), true);
    for (const Pair& other : pairs_)
        if (glm::distance(other.device_from_stylus.position_m, device->pose.position_m) < settings_.closest_m)
            return tell("That place was touched before: go to another.", true);
    pairs_.push_back({device->pose, tracked->pose, Vec3(0.0)});
    tell(filled("Point %.0f is recorded.", double(pairs_.size())), false);
    if (int(pairs_.size()) >= places()) finishPlaces();
}

void Wizard::finishPlaces() {
    if (!settings_.earlier) return conclude(fitPairs(pairs_, fitSettings()));
    const Drift drift = judgeDrift(*settings_.earlier, pairs_);
    verdict_ = {drift.holds, drift.what};
    enter(WizardStage::result);
}

double Wizard::sweepProgress() const {
    if (!recording_s_) return 0.0;
    std::vector<Vec3> tips;
    for (const Rigid& pose : thinned(device_))
        tips.push_back(pose.position_m);
    const double time = (now_s_ - *recording_s_) / settings_.sweep_s,
                 octants = double(std::popcount(octantsReached(settings_.cube, tips))) / kSweepOctants,
                 turn = turned_rad(thinned(tracked_)) / kSweepTurn_rad;
    return std::clamp(std::min({time, octants, turn}), 0.0, 1.0);
}

void Wizard::takeSweep(const WizardInput& in) {
    if (!recording_s_) {
        if (in.press) beginRecording(now_s_);
        return;
    }
    if (in.back) return enter(WizardStage::sweep, "Restarted.");
    const double since_s = now_s_ - *recording_s_;
    if (now_s_ - tried_s_ >= kTryAgain_s) {
        tried_s_ = now_s_;
        if (now_s_ - tracked_s_ > kUnseen_s)
            tell("The headset does not see the controller.", true);
        else if (now_s_ - device_s_ > kUnseen_s)
            tell("The device is not ready.", true);
        else if (speed_m_per_s(device_) > kTooFast_m_per_s)
            tell("Move more slowly.", true);
        else
            tell("", false);
        if (sweepProgress() >= 1.0 || since_s >= kSweepMost_s)
            return conclude(fitMotion(device_, tracked_, fitSettings()));
    }
    if (in.press && since_s > kTipLeast_s) conclude(fitMotion(device_, tracked_, fitSettings()));
}

void Wizard::conclude(Answer<Fit> fit) {
    fit_ = std::move(fit.value);
    verdict_ = fit_ ? judge(*fit_, settings_.limits) : Verdict{false, fit.why_not};
    enter(WizardStage::result);
}

void Wizard::showResult(const WizardInput& in) {
    if (in.press && verdict_.accept) return enter(WizardStage::accepted);
    if (!in.press && !in.back) return;
    if (in.press) settings_.earlier.reset();  // the device has moved: register again from the start
    redo();
}

std::optional<Vec3> Wizard::gripFromTip_m() const {
    const bool known = stage_ != WizardStage::start && stage_ != WizardStage::tip;
    return known ? std::optional(tip_m_) : knownTip_m();
}

WizardSketch Wizard::sketch() const {
    WizardSketch sketch;
    sketch.shown = stage_ == WizardStage::places || stage_ == WizardStage::sweep;
    sketch.cube = settings_.cube;
    if (now_s_ - device_s_ < kUnseen_s) sketch.tip = device_tip_m_;
    if (stage_ == WizardStage::sweep) {
        for (const Rigid& pose : thinned(device_))
            sketch.done.push_back(pose.position_m);
        return sketch;
    }
    for (const Pair& pair : pairs_)
        sketch.done.push_back(pair.device_from_stylus.position_m);
    sketch.next = nextPlace_m();
    for (const Vec3& place : places_)
        if (std::none_of(sketch.done.begin(), sketch.done.end(), [&](const Vec3& done) {
                return glm::distance(done, place) <= kNear * settings_.cube.half_m;
            }))
            sketch.to_do.push_back(place);
    return sketch;
}

std::optional<Vec3> Wizard::nextPlace_m() const {
    if (stage_ != WizardStage::places) return std::nullopt;
    std::vector<Vec3> taken;
    for (const Pair& pair : pairs_)
        taken.push_back(pair.device_from_stylus.position_m);
    return nextPlace(places_, taken, kNear * settings_.cube.half_m);
}

WizardText Wizard::text() const {
    WizardText t;
    t.note = note_, t.warns = warns_;
    const double since_s = recording_s_ ? now_s_ - *recording_s_ : 0.0;
    switch (stage_) {
        case WizardStage::start:
            t.title = settings_.earlier ? "Is the device where it was?" : "Where the device stands";
            t.what =
                "The device is shown its place in the room by a controller whose tip touches its own. Take "
                "one in each hand.";
            t.awaited = warns_ ? "It continues once that is fixed." : "Press the trigger to begin.";
            break;
        case WizardStage::tip:
            t.title = "The controller's tip";
            t.what =
                "Let the device's tip rest. Put the controller's tip on it, keep it there, and turn the "
                "controller about it to all sides.";
            t.awaited = recording_s_ ? "Keep turning." : "Press the trigger, then turn.";
            t.progress = 0.1;
            t.recording = std::clamp(since_s / kTipLeast_s, 0.0, 1.0);
            break;
        case WizardStage::places:
            t.title = filled("Point %.0f of %.0f", double(pairs_.size() + 1), double(places()));
            t.what = "Go to the ringed place, " + nameOfPlace(settings_.cube, *nextPlace_m()) +
                     ", with both tips together. Turn your wrist a little each time, and hold still.";
            t.awaited = recording_s_ ? "Hold still." : "Press the trigger to record the point.";
            t.progress = 0.2 + 0.7 * double(pairs_.size()) / places();
            t.recording = std::clamp(since_s / settings_.hold_s, 0.0, 1.0);
            break;
        case WizardStage::sweep:
            t.title = "Through the whole space";
            t.what =
                "Keep both tips together. Go slowly to every corner the device reaches, and turn your wrist "
                "to all sides as you go.";
            t.awaited = recording_s_ ? "Continue until the bar is full." : "Press the trigger, then move.";
            t.recording = recording_s_ ? sweepProgress() : 0.0;
            t.progress = 0.1 + 0.8 * t.recording;
            break;
        case WizardStage::result:
            t.title = settings_.earlier ? (verdict_.accept ? "It holds" : "It has moved")
                      : verdict_.accept ? "It fits"
                                        : "Once more, please";
            t.what = verdict_.why;
            t.awaited = verdict_.accept     ? settings_.earlier
                                                  ? "Press the trigger to keep it, menu to touch again."
                                                  : "Press the trigger to keep it, menu to do it again."
                        : settings_.earlier ? "Trigger: register again; menu: touch again."
                                            : "Press the trigger to do it again.";
            t.progress = 0.95;
            break;
        case WizardStage::accepted:
            t.title = "Done";
            t.what = verdict_.why;
            t.progress = 1.0;
            break;
    }
    return t;
}

}  // namespace stylet::xr::registration
