// Guides the user through the registration: current instruction, awaited action, progress and result.
// Driven by pose samples and button presses. Displaying the text is up to the caller.
#pragma once

#include <string>
#include <vector>

#include "xr/registration/clock.h"
#include "xr/registration/drift.h"
#include "xr/registration/pivot.h"

namespace stylet::xr::registration {

struct WizardSettings {
    int points = 8;               // number of places to touch and hold
    bool in_motion = false;       // sweep through the cube, tip on tip, instead of touching places
    bool senses_rotation = true;  // whether the device measures its orientation
    // The controller's tip if known; otherwise the wizard calibrates it.
    std::optional<Vec3> grip_from_tip_m{};
    Cube cube{};          // working volume of the tip
    double hold_s = 0.5;  // recording time per place
    double sweep_s = 20.0;
    double min_distance_m = 0.015;  // places closer than this count as the same
    double max_movement_m = 0.004;  // a held tip may move this far
    Limits limits{};
    // An earlier registration to verify. The user touches `touches` places; the verdict states whether it is
    // still valid. If it is not, the user can register again.
    std::optional<StoredRegistration> earlier{};
    int touches = 1;
};

enum class WizardStage { start, tip, places, sweep, result, accepted };

// Input since the last step. Times increase and share one clock.
struct WizardInput {
    double now_s = 0.0;
    std::span<const TimedPose> device{};   // device_from_stylus
    std::span<const TimedPose> tracked{};  // stage_from_grip
    bool press = false;                    // confirm, continue, or record here
    bool back = false;                     // redo the last place; at the result: redo everything
};

// Text and progress to display.
struct WizardText {
    std::string title;        // "Point 3 of 8"
    std::string what;         // instruction
    std::string next_action;  // next action: "Press the trigger to record the point."
    std::string note;         // result of the last action, or the current problem; may be empty
    double progress = 0.0;    // overall progress, 0 to 1
    double recording = 0.0;   // progress of the current recording, 0 to 1; 0 if none
    bool is_warning = false;  // the note is a warning
};

// The working volume in the device frame, for drawing.
struct WizardSketch {
    bool shown = false;
    Cube cube;
    std::vector<Vec3> done;         // touched points, or the path of the sweep so far
    std::vector<Vec3> to_do;        // remaining places
    std::optional<Vec3> next, tip;  // place to touch next; current tip
};

class Wizard {
  public:
    explicit Wizard(const WizardSettings&);
    void step(const WizardInput&);
    WizardText text() const;
    WizardSketch sketch() const;
    WizardStage stage() const { return stage_; }
    // fit() and verdict() are valid in the stages result and accepted.
    const std::optional<Fit>& fit() const { return fit_; }  // empty if an earlier registration was verified
    bool verifiesEarlier() const { return settings_.earlier.has_value(); }
    const Verdict& verdict() const { return verdict_; }
    // Place to touch next, device frame. Only in the stage `places`.
    std::optional<Vec3> nextPlace_m() const;
    std::size_t touchedCount() const { return pairs_.size(); }
    // The controller's tip in the grip frame, if known.
    std::optional<Vec3> gripFromTip_m() const;

  private:
    void enter(WizardStage, std::string note = "", bool is_warning = false);
    void start(const WizardInput&);
    void findTip(const WizardInput&);
    void recordPlace(const WizardInput&);
    void recordSweep(const WizardInput&);
    void showResult(const WizardInput&);
    void setNote(std::string note, bool is_warning);
    void beginRecording(double now_s);
    void finishPlace();
    void finishPlaces();
    void setResult(Result<Fit>);
    void redo();
    std::optional<Vec3> knownTip_m() const;
    int places() const;
    WizardStage afterTip() const;
    double sweepProgress() const;
    FitSettings fitSettings() const;

    WizardSettings settings_;
    WizardStage stage_ = WizardStage::start;
    std::string note_;
    bool is_warning_ = false;
    double now_s_ = 0.0, device_s_, tracked_s_;  // times of the last samples
    Vec3 device_tip_m_{0.0};
    std::optional<double> recording_s_;  // start of the recording
    double last_attempt_s_ = 0.0;
    std::vector<TimedPose> device_, tracked_;  // recorded samples
    Vec3 tip_m_{0.0};
    double tip_sd_m_ = 0.0;
    std::vector<Pair> pairs_;
    std::vector<Vec3> places_;
    std::optional<Fit> fit_;
    Verdict verdict_;
};

}  // namespace stylet::xr::registration
