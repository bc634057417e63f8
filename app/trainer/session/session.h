// Observes every tick of an attempt, writes the record and finds the capture points. It never uses the GPU or
// OpenXR and continues to work if they fail.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/records/record.h"
#include "app/report/curve.h"
#include "app/trainer/session/alert.h"
#include "app/trainer/session/frame_state.h"
#include "app/trainer/session/insertion.h"
#include "app/training/attempt_fold.h"
#include "app/training/procedure.h"
#include "haptics/loop/loop.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// A capture point with the state that is needed to draw it.
struct Capture {
    std::string name;
    FrameState state;
};

// Force added by the passivity controller, over the ticks in contact.
struct ControllerLog {
    std::uint64_t contact_ticks = 0;
    std::uint64_t felt_ticks = 0;  // ticks in which the added force exceeds kFelt_n
    double peak_n = 0.0;
    double sum_n2 = 0.0;
};
inline constexpr double kFelt_n = 0.001;

// A command, the tick that executed it, and the tick before that.
struct ExecutedCommand {
    haptics::Command command;
    haptics::TickOutput before, after;
};

struct SessionLog {
    std::vector<report::ForceSample> curve;       // every tick inside the body
    std::vector<haptics::EventRecord> punctures;  // cuts and entries, in order
    std::vector<Capture> captures;
    // The first tick in which a duct was cut with the target's label at the tip.
    std::optional<haptics::TickOutput> target_cut;
    std::optional<haptics::TickOutput> deepest;  // deepest tick inside the body
    double peak_force_n = 0.0;
    double lateral_cut_m = 0.0;
    std::uint64_t ticks = 0;  // ticks received
    std::uint64_t last_tick = 0;
    std::uint64_t state_hash = 0;
    std::uint32_t faults = 0;         // every bit ever seen
    std::uint32_t awaited = 0;        // bits of the newest tick: what prevents the force from starting
    std::uint64_t awaited_ticks = 0;  // number of ticks without a change of `awaited`
    ControllerLog controller;
    bool equipment_used = false;  // X-ray, contrast medium or ultrasound was used
    training::DoseLedger dose;
    patient::ContrastStatus contrast;
    std::vector<std::vector<haptics::TickRecord>> flights;  // tick histories of the first kMaxFlights faults
    std::uint64_t more_flights = 0;                         // histories that were dropped
    training::Progress progress;                            // of the newest tick
    training::Score score;                                  // of the newest tick
    ForceComparisonReading truth;                           // of the newest tick
    std::vector<training::SessionEvent> events;             // in order
    bool target_hit() const { return target_cut.has_value(); }
};

inline constexpr std::size_t kMaxFlights = 16;

class Session {
  public:
    // `moments`: see Scenario. `record` may be null (a replay records nothing). The arguments must outlive
    // the session.
    Session(const patient::Patient&, const patient::PlannedPath&, const std::vector<std::string>& moments,
            double approach_distance_m, records::RecordWriter* record, double dt_s = 0.001);

    // Call before the first tick. The comparison receives every tick and must outlive the session.
    void compareWith(ForceComparison& truth) { truth_ = &truth; }

    // Call before the first tick. The instruments of holes and pictures; default: those of InstrumentSet.
    void setInstruments(const haptics::InstrumentSet&);

    // Call before the first tick; default: kDefaultCourse.
    void setCourse(training::Course course) { procedure_.setCourse(course); }

    // Call before the first tick; default: no case, and no review.
    void setCase(std::shared_ptr<const training::PatientCase> patient_case) {
        procedure_.setCase(case_ = std::move(patient_case));
    }
    const training::PatientCase* patientCase() const { return case_.get(); }

    // Call before the first tick. Wire, dilator and drain of pictures, and the drain that medium flows
    // through.
    void setAccess(const haptics::AccessSettings& access) {
        access_ = access;
        fold_.setDrain(access.drain);
    }

    // Session thread. Processes everything in the rings. Throws DataError if the record cannot be written.
    void drain(haptics::LoopChannels&);
    // Same for a single tick or event. An event may come before the record of its tick.
    void update(const haptics::TickRecord&);
    void update(const haptics::EventRecord&);
    // A recomputed tick with its events.
    void update(const haptics::TickInput&, const haptics::TickOutput&, const haptics::NeedleEvents&);
    // Called on the session thread after each tick. May throw, like drain().
    using Watcher = std::function<void(const haptics::TickOutput&, const SessionLog&)>;
    void setWatcher(Watcher watcher) { watcher_ = std::move(watcher); }
    // Called after each note. A note may be added while no ticks run.
    void setNoteWatcher(std::function<void(const SessionLog&)> noted) { noted_ = std::move(noted); }

    // Returns true once for each press of the device's re-arm button while the force was off. After a fault,
    // the force needs this explicit request.
    bool popRearm() { return std::exchange(rearm_, false); }
    // Bit of the re-arm button; default: bit 0.
    void setRearmButton(std::uint32_t button) { rearm_button_ = button; }
    // Adds a session event at the newest tick.
    void note(std::string kind, std::string text);
    // Call before the first tick. Sets FrameState::start_refused for the first seconds.
    void setStartRefused(std::string why) { start_refused_ = std::move(why); }
    // Sets FrameState::answer for some seconds.
    void showAnswer(std::string text);
    // Sets FrameState::rest_due from now on.
    void showRest(bool due) { rest_due_ = due; }
    void setDifficulty(training::Difficulty difficulty) {
        difficulty_ = difficulty;
        easiest_ = std::min(easiest_, difficulty);
    }
    std::optional<training::Difficulty> difficulty() const { return difficulty_; }
    // The easiest difficulty so far. It is the one that the attempt counts for.
    training::Difficulty easiestDifficulty() const { return easiest_; }
    // popPressed(), popCommands() and popFaults() return the buttons pressed, commands executed and
    // faults raised since the last call. A fault that recurs after re-arming counts again.
    std::uint32_t popPressed() { return std::exchange(newly_pressed_, 0); }
    // Buttons down in the newest tick; none if the device is lost.
    std::uint32_t buttonsDown() const { return buttons_down_; }
    // Also the instructor's events since the last call, each with the reason if it had no effect.
    std::vector<std::string> popInjected() { return std::exchange(new_injected_, {}); }
    std::vector<ExecutedCommand> popCommands() { return std::exchange(executed_commands_, {}); }
    std::uint32_t popFaults() { return std::exchange(new_faults_, 0); }
    // Discards pressed buttons, commands, faults and the re-arm request. Used after a recomputed beginning,
    // whose events must not be reported as new.
    void discardPending();
    // The newest tick; null before the first.
    const haptics::TickOutput* newest() const { return recent_.empty() ? nullptr : &recent_.back(); }
    // State for frames: `tick` and the session's other state.
    FrameState frameState(const haptics::TickOutput& tick) const;
    // Session thread. Frames receive the contrast medium through ContrastFeed (contrast_feed.h).
    const patient::Contrast& contrast() const { return fold_.contrast(); }
    // Capture points found since the last call, each exactly once.
    std::vector<Capture> newCaptures();
    const SessionLog& log() const { return log_; }

  private:
    void watchUser(const haptics::TickRecord&);
    void watchInstructor(const haptics::TickRecord&);
    void watchForce(const haptics::TickRecord&);
    void watchXray(const haptics::TickOutput&);
    void matchEvents();
    void onEvent(const haptics::EventRecord&, const haptics::TickOutput&);
    void updateProgress();
    void note(const std::string& moment, const haptics::TickOutput&);
    bool targetAtTip(const haptics::TickOutput&) const;

    const patient::Patient& patient_;
    double dt_s_;
    Vec3 entry_m_, axis_;
    std::vector<std::string> awaited_;
    double approach_distance_m_;
    records::RecordWriter* record_;
    training::AttemptFold fold_;
    training::Procedure procedure_;
    std::shared_ptr<const training::PatientCase> case_;
    std::deque<haptics::TickOutput> recent_;  // recent ticks, to find the tick of an event
    std::deque<haptics::EventRecord> unmatched_;
    std::size_t handed_out_ = 0;
    std::uint32_t rearm_button_ = 1u << 0;
    std::uint32_t pressed_ = 0, newly_pressed_ = 0, buttons_down_ = 0, new_faults_ = 0;
    bool rearm_ = false, pedal_ = false, lights_out_ = false, rest_due_ = false;
    std::uint64_t rearm_acts_ = 0;
    std::vector<ExecutedCommand> executed_commands_;
    std::vector<std::string> new_injected_;
    std::string answer_;             // the newest
    std::uint64_t answered_at_ = 0;  // tick
    WoundLog wounds_;
    NeedleShape needle_;
    UltrasoundProbe probe_;
    haptics::AccessSettings access_;
    InsertionLog insertion_;
    GlowWatch glow_;
    ForceComparison* truth_ = nullptr;
    std::string start_refused_;
    std::optional<training::Difficulty> difficulty_;
    training::Difficulty easiest_ = training::Difficulty::exam;
    SessionLog log_;
    Watcher watcher_;
    std::function<void(const SessionLog&)> noted_;
};

}  // namespace stylet::trainer
