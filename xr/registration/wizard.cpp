#include "xr/registration/wizard.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>

#include "xr/registration/places.h"

namespace stylet::xr::registration {
namespace {

constexpr double kStreamTimeout_s = 0.3;  // a pose stream silent for this long counts as lost
constexpr double kTipMinTime_s = 3.0, kTipMaxTime_s = 20.0, kRetryInterval_s = 0.25;
constexpr double kTipSd_m = 0.0007, kTipResidual_m = 0.004, kTipTurn_rad = 0.8;
constexpr double kMinTipSd_m = 0.0003;
constexpr double kSweepMaxTime_s = 60.0, kSweepTurn_rad = 0.7, kTooFast_m_per_s = 0.6;
constexpr int kSweepOctants = 7;
constexpr double kNear = 0.6;  // places within this fraction of half_m of a touched point count as touched
constexpr std::size_t kMinSamples = 5;
constexpr std::size_t kMaxPoses = 150;  // limit of the poses evaluated per stream during a recording

std::vector<Pose> subsample(std::span<const TimedPose> stream) {
    std::vector<Pose> poses;
    const std::size_t step = std::max<std::size_t>(1, stream.size() / kMaxPoses);
    for (std::size_t i = 0; i < stream.size(); i += step)
        poses.push_back(stream[i].pose);
    return poses;
}

std::vector<Vec3> positions(std::span<const TimedPose> stream) {
    std::vector<Vec3> points;
    for (const Pose& pose : subsample(stream))
        points.push_back(pose.position_m);
    return points;
}

double speed_m_per_s(std::span<const TimedPose> stream) {
    if (stream.size() < 2) return 0.0;
    const TimedPose &last = stream.back(), *before = &stream.front();
    for (const TimedPose& s : stream)
        if (last.t_s - s.t_s >= 0.05) before = &s;
    const double dt_s = last.t_s - before->t_s;
    return dt_s > 0.0 ? glm::distance(last.pose.position_m, before->pose.position_m) / dt_s : 0.0;
}

}  // namespace

Wizard::Wizard(const WizardSettings& settings)
    : settings_(settings),
      device_s_(-1e9),
      tracked_s_(-1e9),
      places_(chooseTouchPlaces(settings.cube, std::max(settings.points, 8))) {
    redo();
}

void Wizard::redo() {
    pairs_.clear();
    fit_.reset();
    verdict_ = {};
    tip_m_ = knownTip_m().value_or(Vec3(0.0));
    tip_sd_m_ = kMinTipSd_m;
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

void Wizard::setNote(std::string note, bool is_warning) {
    note_ = std::move(note), is_warning_ = is_warning;
}

void Wizard::enter(WizardStage stage, std::string note, bool is_warning) {
    stage_ = stage;
    recording_s_.reset();
    device_.clear(), tracked_.clear();
    setNote(std::move(note), is_warning);
}

void Wizard::beginRecording(double now_s) {
    recording_s_ = last_attempt_s_ = now_s;
    device_.clear(), tracked_.clear();
    setNote("", false);
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
            return recordPlace(in);
        case WizardStage::sweep:
            return recordSweep(in);
        case WizardStage::result:
            return showResult(in);
        case WizardStage::accepted:
            return;
    }
}

void Wizard::start(const WizardInput& in) {
    const bool device = now_s_ - device_s_ < kStreamTimeout_s,
               tracked = now_s_ - tracked_s_ < kStreamTimeout_s;
    if (!device || !tracked) {
        setNote(!device ? "The haptic device is not ready." : "The headset does not see the controller.",
                true);
        return;
    }
    if (is_warning_) setNote("", false);
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
    if (since_s < kTipMinTime_s || now_s_ - last_attempt_s_ < kRetryInterval_s) return;
    last_attempt_s_ = now_s_;
    const Result<Pivot> pivot = calibratePivot(subsample(tracked_));
    if (pivot && pivot->max_rotation_rad >= kTipTurn_rad && pivot->tip_sd_m <= kTipSd_m &&
        pivot->residual_m <= kTipResidual_m) {
        tip_m_ = pivot->grip_from_tip_m;
        tip_sd_m_ = std::max(kMinTipSd_m, pivot->tip_sd_m);
        enter(afterTip(), fmt::format("The controller's tip is {:.0f} mm from its grip, found to {:.1f} mm.",
                                      1e3 * glm::length(tip_m_), 1e3 * tip_sd_m_));
        return;
    }
    if (since_s < kTipMaxTime_s) {
        setNote(pivot ? "Turn it farther, to all sides." : pivot.why_not, false);
        return;
    }
    enter(WizardStage::tip,
          pivot ? fmt::format("The tip slipped by {:.1f} mm: press and try again.", 1e3 * pivot->residual_m)
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

void Wizard::recordPlace(const WizardInput& in) {
    if (recording_s_) {
        if (now_s_ - *recording_s_ >= settings_.hold_s) finishPlace();
        return;
    }
    if (in.back && !pairs_.empty()) {
        pairs_.pop_back();
        setNote("The last point was removed.", false);
    } else if (in.press) {
        beginRecording(now_s_);
    }
}

void Wizard::finishPlace() {
    const Result<MeanPose> device = meanPose(device_), tracked = meanPose(tracked_);
    const bool seen = device_.size() >= kMinSamples && tracked_.size() >= kMinSamples;
    enter(WizardStage::places);
    if (!seen || !device || !tracked)
        return setNote(device_s_ < now_s_ - kStreamTimeout_s ? "The device was not ready: press again."
                                                             : "The controller was not seen: press again.",
                       true);
    const double moved_m = std::max(device->spread_m, tracked->spread_m);
    if (moved_m > settings_.max_movement_m)
        return setNote(fmt::format("It moved by {:.0f} mm: hold still and press again.", 1e3 * moved_m),
                       true);
    for (const Pair& other : pairs_)
        if (glm::distance(other.device_from_stylus.position_m, device->pose.position_m) <
            settings_.min_distance_m)
            return setNote("That place was touched before: go to another.", true);
    pairs_.push_back({device->pose, tracked->pose, Vec3(0.0)});
    setNote(fmt::format("Point {} is recorded.", pairs_.size()), false);
    if (int(pairs_.size()) >= places()) finishPlaces();
}

void Wizard::finishPlaces() {
    if (!settings_.earlier) return setResult(fitPairs(pairs_, fitSettings()));
    const Drift drift = checkDrift(*settings_.earlier, pairs_);
    verdict_ = {drift.valid, drift.what};
    enter(WizardStage::result);
}

double Wizard::sweepProgress() const {
    if (!recording_s_) return 0.0;
    const std::vector<Pose> grips = subsample(tracked_);
    const double turn_rad = grips.empty() ? 0.0 : maxRotation_rad(grips.front().rotation, grips);
    const int octants = std::popcount(octantsReached(settings_.cube, positions(device_)));
    const double time = (now_s_ - *recording_s_) / settings_.sweep_s;
    return std::clamp(std::min({time, double(octants) / kSweepOctants, turn_rad / kSweepTurn_rad}), 0.0, 1.0);
}

void Wizard::recordSweep(const WizardInput& in) {
    if (!recording_s_) {
        if (in.press) beginRecording(now_s_);
        return;
    }
    if (in.back) return enter(WizardStage::sweep, "Restarted.");
    const double since_s = now_s_ - *recording_s_;
    if (now_s_ - last_attempt_s_ >= kRetryInterval_s) {
        last_attempt_s_ = now_s_;
        if (now_s_ - tracked_s_ > kStreamTimeout_s)
            setNote("The headset does not see the controller.", true);
        else if (now_s_ - device_s_ > kStreamTimeout_s)
            setNote("The device is not ready.", true);
        else if (speed_m_per_s(device_) > kTooFast_m_per_s)
            setNote("Move more slowly.", true);
        else
            setNote("", false);
        if (sweepProgress() >= 1.0 || since_s >= kSweepMaxTime_s)
            return setResult(fitMotion(device_, tracked_, fitSettings()));
    }
    if (in.press && since_s > kTipMinTime_s) setResult(fitMotion(device_, tracked_, fitSettings()));
}

void Wizard::setResult(Result<Fit> fit) {
    fit_ = std::move(fit.value);
    verdict_ = fit_ ? evaluateFit(*fit_, settings_.limits) : Verdict{false, fit.why_not};
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
    if (now_s_ - device_s_ < kStreamTimeout_s) sketch.tip = device_tip_m_;
    if (stage_ == WizardStage::sweep) {
        sketch.done = positions(device_);
        return sketch;
    }
    sketch.done = deviceTips(pairs_);
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
    return nextPlace(places_, deviceTips(pairs_), kNear * settings_.cube.half_m);
}

WizardText Wizard::text() const {
    const double since_s = recording_s_ ? now_s_ - *recording_s_ : 0.0;
    const auto make = [&](std::string title, std::string what, std::string next_action, double progress,
                          double recording = 0.0) {
        return WizardText{std::move(title),
                          std::move(what),
                          std::move(next_action),
                          note_,
                          progress,
                          std::clamp(recording, 0.0, 1.0),
                          is_warning_};
    };
    switch (stage_) {
        case WizardStage::start:
            return make(
                settings_.earlier ? "Is the device where it was?" : "Where the device stands",
                "The device is shown its place in the room by a controller whose tip touches its own. Take "
                "one in each hand.",
                is_warning_ ? "It continues once that is fixed." : "Press the trigger to begin.", 0.0);
        case WizardStage::tip:
            return make(
                "The controller's tip",
                "Let the device's tip rest. Put the controller's tip on it, keep it there, and turn the "
                "controller about it to all sides.",
                recording_s_ ? "Keep turning." : "Press the trigger, then turn.", 0.1,
                since_s / kTipMinTime_s);
        case WizardStage::places:
            return make(fmt::format("Point {} of {}", pairs_.size() + 1, places()),
                        "Go to the ringed place, " + describePlace(settings_.cube, *nextPlace_m()) +
                            ", with both tips together. Turn your wrist a little each time, and hold still.",
                        recording_s_ ? "Hold still." : "Press the trigger to record the point.",
                        0.2 + 0.7 * double(pairs_.size()) / places(), since_s / settings_.hold_s);
        case WizardStage::sweep: {
            const double recording = sweepProgress();
            return make(
                "Through the whole space",
                "Keep both tips together. Go slowly to every corner the device reaches, and turn your wrist "
                "to all sides as you go.",
                recording_s_ ? "Continue until the bar is full." : "Press the trigger, then move.",
                0.1 + 0.8 * recording, recording);
        }
        case WizardStage::result:
            if (settings_.earlier)
                return make(verdict_.accept ? "It holds" : "It has moved", verdict_.why,
                            verdict_.accept ? "Press the trigger to keep it, menu to touch again."
                                            : "Trigger: register again; menu: touch again.",
                            0.95);
            return make(verdict_.accept ? "It fits" : "Once more, please", verdict_.why,
                        verdict_.accept ? "Press the trigger to keep it, menu to do it again."
                                        : "Press the trigger to do it again.",
                        0.95);
        case WizardStage::accepted:
            return make("Done", verdict_.why, "", 1.0);
    }
    return {};
}

}  // namespace stylet::xr::registration
