#include "app/trainer/loop/loops.h"

#include <fmt/core.h>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <exception>
#include <future>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "app/trainer/loop/force_feed.h"
#include "app/trainer/loop/picture_watch.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/training/equipment.h"
#include "base/rings.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

using haptics::Clock;
using haptics::LoopChannels;
using haptics::TickOutput;

namespace {

constexpr std::int64_t kSessionPeriod_ns = 2'000'000;
// Time for the session thread to run once, unless the computer is overloaded.
constexpr int kCutPatience_ms = 20;

// True if something was cut between the two ticks, or may have been cut.
bool cutBetween(const TickOutput& a, const TickOutput& b) {
    return a.phase != b.phase || a.tissue != b.tissue || a.incision_count != b.incision_count;
}

// Passes states to show from the session to the frame loop. Neither side has a deadline, so a lock is
// sufficient.
class FrameStateQueue {
  public:
    void add(std::vector<Capture> captures, FrameState newest) {
        const std::lock_guard lock(mutex_);
        newest_ = std::move(newest);
        for (Capture& capture : captures)
            waiting_.push_back(std::move(capture));
    }
    std::optional<Capture> next() {
        const std::lock_guard lock(mutex_);
        if (waiting_.empty()) return std::nullopt;
        Capture first = std::move(waiting_.front());
        waiting_.pop_front();
        return first;
    }
    // True if there was a cut up to `tick` that the session has not yet processed.
    bool isMissingCut(const TickOutput& tick) {
        const std::lock_guard lock(mutex_);
        return newest_.tick.tick < tick.tick && cutBetween(newest_.tick, tick);
    }
    // The newest state with its tick replaced by a later one.
    FrameState newest(const TickOutput& tick) {
        const std::lock_guard lock(mutex_);
        FrameState at_tick = newest_;
        at_tick.tick = tick;
        return at_tick;
    }

  private:
    std::mutex mutex_;
    std::deque<Capture> waiting_;
    FrameState newest_;
};

// Sends each command of the trace at its time, or later when the ring has space.
class CommandFeed {
  public:
    // Commands before `from_ns` were already sent.
    CommandFeed(const haptics::Trace& trace, std::int64_t from_ns) : trace_(trace) {
        while (next_ < trace.commands.size() && trace.commands[next_].t_ns < from_ns)
            ++next_;
    }
    void until(std::int64_t t_ns, Ring<haptics::Command>& ring) {
        while (next_ < trace_.commands.size() && trace_.commands[next_].t_ns <= t_ns &&
               ring.push(trace_.commands[next_].command))
            ++next_;
    }
    // True if the ticks have consumed every command.
    bool done(const Ring<haptics::Command>& ring) const {
        return next_ == trace_.commands.size() && ring.empty();
    }

  private:
    const haptics::Trace& trace_;
    std::size_t next_ = 0;
};

std::int64_t duration_ns(const haptics::Trace& trace) {
    return trace.samples.back().t_ns;
}

std::int64_t tickPeriod_ns(const Attempt& attempt) {
    return std::llround(attempt.simulation.dt_s * 1e9);
}

// Commands from this time on must still be sent. A tick consumes the commands of its own time, so those of
// the last tick of the beginning were already sent.
std::int64_t sentUntil_ns(const Attempt& attempt) {
    return attempt.beginning.empty() ? 0 : attempt.begun_ns() - tickPeriod_ns(attempt) + 1;
}

// Computes one tick without the real-time loop and passes it to the session.
void stepOnce(haptics::Simulation& simulation, Session& session, haptics::TickRecord& record) {
    haptics::NeedleEvents events;
    simulation.step(record.input, record.output, events);
    session.update(record.input, record.output, events);
}

// Computes the beginning (recorded ticks of an earlier attempt) before the threads start. Returns the last
// tick.
TickOutput computeBeginning(const Attempt& attempt, haptics::Simulation& simulation, Session& session) {
    haptics::TickRecord record;
    for (const haptics::TickInput& input : attempt.beginning) {
        record.input = input;
        stepOnce(simulation, session, record);
    }
    session.discardPending();
    return record.output;
}

// Fades the force out as in a pause, so that the user takes over at zero force. These ticks belong to the
// attempt. During them the device rests, and pedal and injection are off.
TickOutput fadeForceOut(const Attempt& attempt, haptics::Simulation& simulation, Session& session) {
    constexpr int kMaxTicks = 1000;
    haptics::TickRecord record;
    const haptics::ForceStage& stage = record.output.stage;
    record.input.device = attempt.beginning.back().device;
    record.input.device.fresh = 1;
    record.input.command_count = 3;
    record.input.commands[0] = {haptics::CommandKind::focus, 0};
    record.input.commands[1] = training::kPedalUp;
    record.input.commands[2] = {haptics::CommandKind::inject, 0};
    for (int i = 0; i < kMaxTicks; ++i) {
        stepOnce(simulation, session, record);
        record.input.command_count = 0;
        if (stage == haptics::ForceStage::off || stage == haptics::ForceStage::waiting) break;
    }
    session.discardPending();
    return record.output;
}

// Draws captures first, then the newest state. If the display fails, reports it once and continues without
// pictures.
class FrameSource {
  public:
    FrameSource(std::unique_ptr<Display> pictures, ContrastFeed& contrast)
        : pictures_(std::move(pictures)), contrast_feed_(&contrast) {}
    bool open() const { return pictures_ != nullptr; }
    Attention attention() const { return pictures_ ? pictures_->attention() : Attention::absent; }
    bool endRequested() const { return end_requested_; }  // the runtime asked to end
    void show(const FrameState&, const std::string& moment);
    void close();  // closes the display; its totals remain available
    PictureTotals totals() const { return pictures_ ? pictures_->totals() : last_; }

  private:
    std::unique_ptr<Display> pictures_;
    ContrastFeed* contrast_feed_;
    patient::ContrastTable contrast_;
    PictureTotals last_;
    bool end_requested_ = false;
};

void FrameSource::show(const FrameState& seen, const std::string& moment) {
    if (!pictures_) return;
    contrast_feed_->applyTo(contrast_);
    try {
        if (pictures_->frame(seen, contrast_.revision > 0 ? &contrast_ : nullptr, moment)) return;
        end_requested_ = true;
        printMessage(fmt::format("{}; the attempt continues without pictures", pictures_->endReason()));
    } catch (const std::runtime_error& e) {
        printMessage(fmt::format("pictures were lost: {}; the attempt continues without them", e.what()));
    }
    close();
}

void FrameSource::close() {
    if (!pictures_) return;
    last_ = pictures_->totals();
    pictures_.reset();
}

// Data shared with the frame thread. That thread may hang in the runtime forever, so this data may outlive
// the attempt.
struct FrameSide {
    FrameSide(double dt_s, std::unique_ptr<Display> pictures, const Clock& clock_in)
        : channels(dt_s),
          worn(pictures != nullptr),
          clock(clock_in),
          frames(followed(std::move(pictures)), contrast) {}

    LoopChannels channels;
    FrameStateQueue states;
    ContrastFeed contrast;
    const bool worn;
    const Clock clock;
    TickOutput latest;  // used by the frame thread only, like the next member
    bool begun = false;
    FrameSource frames;
    std::atomic<Attention> attention{worn ? Attention::absent : Attention::focused};
    std::atomic<std::int64_t> sign_ns{clock.now_ns(clock.context)};  // when the frame thread was last active
    std::atomic<bool> end_requested{false};                          // the runtime asked to end
    std::atomic<bool> ended{false};                                  // the attempt has ended
    std::exception_ptr failure;                                      // exception of the frame thread itself
    std::atomic<std::uint64_t> shown{0};
    std::promise<PictureTotals> totals;

    std::unique_ptr<Display> followed(std::unique_ptr<Display> pictures) {
        if (pictures)
            pictures->follow({&channels.tips,
                              [this](FrameState& seen_so_far) { seen_so_far = newestState(); },
                              [this](Attention now) { attention.store(now); }});
        return pictures;
    }
    // Returns the state at the newest tick. Waits briefly for the session, so that a cut and its wound appear
    // together.
    FrameState newestState() {
        channels.latest.read(latest);
        for (int ms = 0; ms < kCutPatience_ms && states.isMissingCut(latest); ++ms)
            clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + 1'000'000);
        FrameState now = states.newest(latest);
        now.ticks_paused = channels.paused.load(), now.return_distance_m = channels.return_distance_m.load();
        return now;
    }
    // Draws the next capture or state. Returns false if there is nothing new.
    bool showNext() {
        begun = channels.latest.read(latest) || begun;
        if (const auto capture = states.next(); capture && frames.open())
            frames.show(capture->state, capture->name);
        else if (begun && frames.open() && !ended.load())
            frames.show(newestState(), "");
        else
            return capture.has_value();
        ++shown;
        return true;
    }
    // Entry point of the frame thread.
    void run() {
        try {
            showAll();
        } catch (...) {
            failure = std::current_exception();
        }
        totals.set_value(frames.totals());
    }
    void showAll() {
        while (true) {
            const bool last = ended.load();
            sign_ns.store(clock.now_ns(clock.context));
            const bool drew = showNext();
            if (worn) attention.store(frames.attention());
            end_requested.store(frames.endRequested());
            if (drew) continue;
            if (last) break;
            clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + kSessionPeriod_ns);
        }
        frames.close();  // here, so that frame_patience_s also applies if the runtime hangs on closing
    }
};

// The session thread. Sends commands at their time and reads records. Ends when trace and commands are
// finished or the user ends the attempt. Script time is the loop's time, tick * dt: if the loop is late, the
// script waits for it.
void sessionLoop(const std::stop_token& stop, const Attempt& attempt, Session& session, FrameSide& side,
                 ForceFeed& force, const RealTimeOptions& options) {
    LoopChannels& channels = side.channels;
    const Clock& clock = side.clock;
    const std::int64_t dt_ns = tickPeriod_ns(attempt), begun_ns = attempt.begun_ns();
    CommandFeed commands(attempt.hand, sentUntil_ns(attempt));
    const std::uint64_t first = session.log().last_tick;  // last tick of the beginning
    std::int64_t hand_ns = begun_ns;
    PictureWatch watch;
    const bool input_only = options.live && haptics::isInputOnly(options.live->device.profile());
    const auto over = [&] {
        return options.live
                   ? side.end_requested.load() || options.live->over(double(hand_ns - begun_ns) * 1e-9)
                   : (hand_ns >= duration_ns(attempt.hand) && commands.done(channels.commands)) ||
                         (force.paused() && side.end_requested.load());  // nobody is left to resume it
    };
    while (!stop.stop_requested() && !over() && !force.next() && !force.aborted()) {
        commands.until(hand_ns, channels.commands);
        clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + kSessionPeriod_ns);
        session.drain(channels);
        const std::int64_t now_ns = clock.now_ns(clock.context);
        if (side.worn)
            if (const std::string text = watch.update(now_ns, side.sign_ns.load(), force.paused());
                !text.empty())
                printMessage(text);
        // Without a moving picture the user no longer sees what is felt.
        const Attention attention = watch.stalled() ? Attention::absent : side.attention.load();
        force.update(attention == Attention::focused, session, channels.commands, watch.stalled());
        channels.pause.store(attention == Attention::away || force.paused());
        FrameState now = session.frameState(session.newest() ? *session.newest() : TickOutput{});
        now.input_only = input_only;
        now.picture_stall_s = watch.shown_s(now_ns, (now.tick.faults & haptics::kFaultNotFocused) != 0);
        now.ticks_paused = channels.paused.load();
        now.paused_by_instructor = force.paused();
        if (options.help && session.newest()) options.help(now);
        if (options.on_state && session.newest()) options.on_state(now);
        side.states.add(session.newCaptures(), std::move(now));
        if (side.worn) side.contrast.publish(session.contrast());
        hand_ns = begun_ns + std::int64_t(session.log().last_tick - first) * dt_ns;
    }
}

// Returns the picture totals after the last frame. Returns nothing if no frame completes within
// `frame_patience_s`.
std::optional<PictureTotals> waitForTotals(FrameSide& side, double frame_patience_s) {
    const std::chrono::duration<double> patience(frame_patience_s);
    auto totals = side.totals.get_future();
    for (std::uint64_t before = side.shown.load();; before = side.shown.load()) {
        if (totals.wait_for(patience) == std::future_status::ready) return totals.get();
        if (side.shown.load() == before) return std::nullopt;
    }
}

// Exits without destroying anything, because a stuck thread still uses it.
[[noreturn]] void exitAtOnce(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& e) {
        printMessage(e.what());
    }
    std::fflush(nullptr);
    std::_Exit(2);
}

}  // namespace

LoopTotals runRealTime(const Attempt& attempt, Session& session, std::unique_ptr<Display> pictures,
                       const Clock& clock, const RealTimeOptions& options) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap(),
                                   attempt.ductSpace());
    const bool input_only = options.live && haptics::isInputOnly(options.live->device.profile());
    const auto side = std::make_shared<FrameSide>(attempt.simulation.dt_s, std::move(pictures), clock);
    LoopChannels& channels = side->channels;
    LoopTotals totals;
    totals.input_only = input_only;
    totals.live = options.live != nullptr;
    // A real user takes over as after a pause. A script continues without a pause.
    const bool resumes = !attempt.beginning.empty() && (options.live || side->worn);
    if (!attempt.beginning.empty()) {
        TickOutput newest = computeBeginning(attempt, simulation, session);
        if (resumes) newest = fadeForceOut(attempt, simulation, session);
        channels.paused.store(resumes);
        channels.latest.publish(newest);
        side->states.add(session.newCaptures(), session.frameState(newest));
    } else if (side->worn) {
        channels.commands.push({haptics::CommandKind::focus, 0});
    }
    const bool focused = !side->worn && simulation.state().output.safety.focused;
    std::exception_ptr failure;

    // If an exception is thrown below, each thread is asked to stop and is joined.
    std::jthread haptics_thread([&](const std::stop_token& stop) {
        const std::stop_callback stopped(stop, [&] { channels.stop.store(true); });
        const std::string refused = requestRealTime();
        if (!refused.empty()) printMessage(refused);
        const std::int64_t begin_ns = clock.now_ns(clock.context);
        haptics::ReplayDevice scripted(attempt.hand, -attempt.begun_ns(), attempt.simulation.profile);
        haptics::HapticDevice& device = options.live ? options.live->device : scripted;
        totals.haptics = runLoop(simulation, device, channels, clock);
        totals.elapsed_s = double(clock.now_ns(clock.context) - begin_ns) * 1e-9;
    });
    std::jthread session_thread([&](const std::stop_token& stop) {
        try {
            ForceFeed force(focused, attempt.simulation.dt_s, options.live, printMessage, options.console,
                            resumes);
            sessionLoop(stop, attempt, session, *side, force, options);
            totals.next = force.next();
            totals.aborted = force.aborted();
        } catch (...) {
            failure = std::current_exception();
        }
        channels.stop.store(true);
    });
    std::thread frame_thread([side, attempt_stop = session_thread.get_stop_source()]() mutable {
        side->run();
        if (side->failure) attempt_stop.request_stop();
    });

    session_thread.join();
    haptics_thread.join();
    channels.flights.finish();
    totals.flights_missed = channels.flights.dropped();
    if (!failure) try {
            session.drain(channels);
            side->states.add(session.newCaptures(), session.frameState({}));
            if (side->worn) side->contrast.publish(session.contrast());
        } catch (...) {
            failure = std::current_exception();
        }
    side->ended.store(true);
    if (auto last = waitForTotals(*side, options.frame_patience_s)) {
        totals.pictures = std::move(*last);
        frame_thread.join();
        if (!failure) failure = side->failure;
    } else {
        totals.frames_stuck = true;
        totals.pictures.frames = side->shown.load();  // the rest still belongs to the frame thread
        frame_thread.detach();
        if (failure) exitAtOnce(failure);
    }
    if (failure) std::rethrow_exception(failure);
    return totals;
}

LoopTotals runFast(const Attempt& attempt, Session& session, std::unique_ptr<Display> pictures, double fps,
                   const Clock& clock) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap(),
                                   attempt.ductSpace());
    haptics::ReplayDevice device(attempt.hand, 0, attempt.simulation.profile);
    LoopChannels channels(attempt.simulation.dt_s);
    LoopTotals totals;
    CommandFeed commands(attempt.hand, sentUntil_ns(attempt));
    ContrastFeed contrast;
    FrameSource frames(std::move(pictures), contrast);
    const std::int64_t dt_ns = tickPeriod_ns(attempt);
    double next_frame_s = double(attempt.begun_ns()) * 1e-9;
    TickOutput latest;
    if (!attempt.beginning.empty()) computeBeginning(attempt, simulation, session);
    ForceFeed force(simulation.state().output.safety.focused, attempt.simulation.dt_s);
    for (std::int64_t now_ns = attempt.begun_ns();
         now_ns <= duration_ns(attempt.hand) || !commands.done(channels.commands); now_ns += dt_ns) {
        commands.until(now_ns, channels.commands);
        loopTick(simulation, device, channels, totals.haptics, now_ns, {clock});
        session.drain(channels);
        force.update(true, session, channels.commands);
        for (const Capture& capture : session.newCaptures()) {
            contrast.publish(session.contrast());
            frames.show(capture.state, capture.name);
        }
        if (!frames.open() || fps <= 0.0 || double(now_ns) * 1e-9 < next_frame_s) continue;
        channels.latest.read(latest);
        contrast.publish(session.contrast());
        frames.show(session.frameState(latest), "");
        next_frame_s += 1.0 / fps;
    }
    channels.flights.finish();
    totals.flights_missed = channels.flights.dropped();
    session.drain(channels);
    totals.elapsed_s = double(totals.haptics.ticks) * attempt.simulation.dt_s;
    totals.pictures = frames.totals();
    return totals;
}

}  // namespace stylet::trainer
