// What became of an attempt: the session watches every tick, keeps the record and finds the moments worth a
// picture. It never touches GPU or OpenXR, and outlives both.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/records/record.h"
#include "app/report/curve.h"
#include "app/trainer/alert.h"
#include "app/trainer/insertion.h"
#include "app/trainer/seen.h"
#include "app/training/attempt_fold.h"
#include "app/training/procedure.h"
#include "haptics/loop.h"
#include "patient/planning.h"

namespace stylet::trainer {

// An instant with everything a picture of it needs.
struct Moment {
    std::string name;
    Seen seen;
};

// What the passivity controller added, over the ticks in contact.
struct ControllerLog {
    std::uint64_t contact_ticks = 0;
    std::uint64_t felt_ticks = 0;  // more than kFelt_n
    double peak_n = 0.0;
    double sum_n2 = 0.0;
};
inline constexpr double kFelt_n = 0.001;

// A command in the tick that took it, with what was before.
struct Taken {
    haptics::Command command;
    haptics::TickOutput before, after;
};

struct SessionLog {
    std::vector<report::ForceSample> curve;       // every tick inside the body
    std::vector<haptics::EventRecord> punctures;  // cuts and entries, in order
    std::vector<Moment> moments;
    // The first cut of a duct with the target's label at the tip.
    std::optional<haptics::TickOutput> target_cut;
    std::optional<haptics::TickOutput> deepest;  // inside the body
    double peak_force_n = 0.0;
    double lateral_cut_m = 0.0;
    std::uint64_t ticks = 0;  // received
    std::uint64_t last_tick = 0;
    std::uint64_t state_hash = 0;
    std::uint32_t faults = 0;         // every bit ever seen
    std::uint32_t awaited = 0;        // of the newest tick: what keeps the force from beginning
    std::uint64_t awaited_ticks = 0;  // for so long the same
    ControllerLog controller;
    bool machines_used = false;  // X-ray, contrast medium, ultrasound: the next two have something to say
    training::DoseLedger dose;
    patient::ContrastStatus contrast;
    std::vector<std::vector<haptics::TickRecord>> flights;  // of the first kMaxFlights faults
    std::uint64_t more_flights = 0;                         // that were not kept
    training::Progress progress;                            // of the newest tick
    training::Score score;                                  // the same
    ForceTruthReading truth;                                // the same
    std::vector<training::SessionEvent> events;             // in order
    bool target_hit() const { return target_cut.has_value(); }
};

inline constexpr std::size_t kMaxFlights = 16;

class Session {
  public:
    // `moments` as in Scenario; `record` may be null (a replay records nothing). All must outlive the
    // session.
    Session(const patient::Patient&, const patient::PlannedPath&, const std::vector<std::string>& moments,
            double approach_distance_m, records::RecordWriter* record, double dt_s = 0.001);

    // Before the first tick: the meter that is fed them. It must outlive the session.
    void compareWith(ForceTruth& truth) { truth_ = &truth; }

    // Session thread. Takes all that waits in the rings; throws patient::DataError when the record cannot be
    // kept.
    void drain(haptics::LoopChannels&);
    // The same, one by one. An event may come before the record of its tick.
    void take(const haptics::TickRecord&);
    void take(const haptics::EventRecord&);
    // A tick that was computed again, with its events.
    void take(const haptics::TickInput&, const haptics::TickOutput&, const haptics::NeedleEvents&);
    // Session thread: called after each tick with what is known then. May throw as drain() does.
    using Watcher = std::function<void(const haptics::TickOutput&, const SessionLog&)>;
    void setWatcher(Watcher watcher) { watcher_ = std::move(watcher); }
    // The same after a note, which may come while there are no ticks.
    void setNoteWatcher(std::function<void(const SessionLog&)> noted) { noted_ = std::move(noted); }

    // The explicit act after a fault: the device's re-arming button was pressed while the force was off. Once
    // a press.
    bool takeRearm();
    // Its bit; the first one until told.
    void setRearmButton(std::uint32_t button) { rearm_button_ = button; }
    // An event of the session's own, at the newest tick.
    void note(std::string kind, std::string text);
    // From now on in all that is seen.
    void showRest(bool due) { rest_due_ = due; }
    void setDifficulty(training::Difficulty difficulty) { difficulty_ = difficulty; }
    std::optional<training::Difficulty> difficulty() const { return difficulty_; }
    // Buttons pressed, commands taken and faults that came (again, after re-arming) since the last call.
    std::uint32_t takePressed() { return std::exchange(newly_pressed_, 0); }
    // Buttons held in the newest tick; a device that is lost holds none.
    std::uint32_t held() const { return held_; }
    std::vector<Taken> takeCommands() { return std::exchange(taken_, {}); }
    std::uint32_t takeFaults() { return std::exchange(new_faults_, 0); }
    // As if all of these had been taken: what there was to be told of a beginning is no news.
    void forgetNews();
    // The newest tick; null before the first.
    const haptics::TickOutput* newest() const { return recent_.empty() ? nullptr : &recent_.back(); }
    // `tick` with what the session knows besides.
    Seen seen(const haptics::TickOutput& tick) const;
    // As of the newest tick. Session thread; trivially copyable, for frames.
    const training::Machines& machines() const { return fold_.machines(); }
    // Session thread. What a picture of it needs goes through ContrastFeed (contrast_feed.h).
    const patient::Contrast& contrast() const { return fold_.contrast(); }
    // Moments found since the last call, each exactly once.
    std::vector<Moment> newMoments();
    const SessionLog& log() const { return log_; }

  private:
    void watchUser(const haptics::TickRecord&);
    void watchInstructor(const haptics::TickRecord&);
    void watchForce(const haptics::TickRecord&);
    void watchXray(const haptics::TickOutput&);
    void settleEvents();
    void onEvent(const haptics::EventRecord&, const haptics::TickOutput&);
    void takeProgress();
    void note(const std::string& moment, const haptics::TickOutput&);
    bool targetAtTip(const haptics::TickOutput&) const;

    const patient::Patient& patient_;
    patient::Vec3 entry_m_, axis_;
    std::vector<std::string> awaited_;
    double approach_distance_m_;
    records::RecordWriter* record_;
    training::AttemptFold fold_;
    training::Procedure procedure_;
    std::deque<haptics::TickOutput> recent_;  // to look an event's tick up in
    std::deque<haptics::EventRecord> unsettled_;
    std::size_t handed_out_ = 0;
    std::uint32_t rearm_button_ = 1u << 0;
    std::uint32_t pressed_ = 0, newly_pressed_ = 0, held_ = 0, new_faults_ = 0;
    bool rearm_ = false, pedal_ = false, lights_out_ = false, rest_due_ = false;
    std::uint64_t rearm_acts_ = 0;
    std::vector<Taken> taken_;
    WoundLog wounds_;
    InsertionLog insertion_;
    GlowWatch glow_;
    ForceTruth* truth_ = nullptr;
    std::optional<training::Difficulty> difficulty_;
    SessionLog log_;
    Watcher watcher_;
    std::function<void(const SessionLog&)> noted_;
};

}  // namespace stylet::trainer
