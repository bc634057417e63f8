// The registration as its user meets it: what to do, what is awaited, how far it is, what came of it. Driven
// by samples and presses; what shows the text is not its business.
#pragma once

#include <string>
#include <vector>

#include "xr/registration/clock.h"
#include "xr/registration/drift.h"
#include "xr/registration/pivot.h"

namespace stylet::xr::registration {

struct WizardSettings {
    int points = 8;                         // to be held
    bool in_motion = false;                 // instead: tip on tip, through the whole space
    bool senses_rotation = true;            // of the device
    std::optional<Vec3> grip_from_tip_m{};  // known; else it is found
    Cube cube;                              // where the tip works
    double hold_s = 0.5;                    // of one point
    double sweep_s = 20.0;
    double closest_m = 0.015;   // two points of their own
    double stillest_m = 0.004;  // a held tip may wander so far
    Limits limits{};
    // One from earlier that is asked about: `touches` places are touched again, and the verdict is whether it
    // holds. Where it does not, the registration follows.
    std::optional<Stored> earlier{};
    int touches = 1;
};

enum class WizardStage { start, tip, places, sweep, result, accepted };

// What happened since the last step; times grow, and are those of one clock.
struct WizardInput {
    double now_s = 0.0;
    std::span<const Timed> device{};   // device_from_stylus
    std::span<const Timed> tracked{};  // stage_from_grip
    bool press = false;                // yes, go on, here
    bool back = false;                 // the last one again; at the result: all of it
};

// To be shown.
struct WizardText {
    std::string title;       // "Point 3 of 8"
    std::string what;        // what to do
    std::string awaited;     // what goes on with it: "Press to take the point."
    std::string note;        // what came of the last act, or is wrong now; may be empty
    double progress = 0.0;   // of the whole, 0 to 1
    double recording = 0.0;  // of what is being recorded, 0 to 1; 0: nothing is
    bool warns = false;      // the note is a warning
};

// The space from the device's side, for a drawing of it.
struct WizardSketch {
    bool shown = false;
    Cube cube;
    std::vector<Vec3> done;         // points, or the way so far
    std::vector<Vec3> to_do;        // places that are left
    std::optional<Vec3> next, tip;  // the place to go to; where the tip is
};

class Wizard {
  public:
    explicit Wizard(const WizardSettings&);
    void step(const WizardInput&);
    WizardText text() const;
    WizardSketch sketch() const;
    WizardStage stage() const { return stage_; }
    // At the result and once accepted.
    const std::optional<Fit>& fit() const { return fit_; }  // of a registration, not of a question
    bool asksAboutEarlier() const { return settings_.earlier.has_value(); }
    const Verdict& verdict() const { return verdict_; }
    // Where the next point is to be touched, device frame; at the places.
    std::optional<Vec3> nextPlace_m() const;
    std::size_t taken() const { return pairs_.size(); }
    // The controller's tip, once it is known.
    std::optional<Vec3> gripFromTip_m() const;

  private:
    void enter(WizardStage, std::string note = "", bool warns = false);
    void start(const WizardInput&);
    void findTip(const WizardInput&);
    void takePlace(const WizardInput&);
    void takeSweep(const WizardInput&);
    void showResult(const WizardInput&);
    void tell(std::string note, bool warns);
    void beginRecording(double now_s);
    void finishPlace();
    void finishPlaces();
    void conclude(Answer<Fit>);
    void redo();
    std::optional<Vec3> knownTip_m() const;
    int places() const;
    WizardStage afterTip() const;
    double sweepProgress() const;
    FitSettings fitSettings() const;

    WizardSettings settings_;
    WizardStage stage_ = WizardStage::start;
    std::string note_;
    bool warns_ = false;
    double now_s_ = 0.0, device_s_, tracked_s_;  // last seen
    Vec3 device_tip_m_{0.0};
    std::optional<double> recording_s_;  // since
    double tried_s_ = 0.0;
    std::vector<Timed> device_, tracked_;  // recorded
    Vec3 tip_m_{0.0};
    double tip_sd_m_ = 0.0;
    std::vector<Pair> pairs_;
    std::vector<Vec3> places_;
    std::optional<Fit> fit_;
    Verdict verdict_;
};

}  // namespace stylet::xr::registration
