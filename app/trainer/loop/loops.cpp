#include "app/trainer/loop/loops.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <future>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "app/trainer/loop/force_feed.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/training/machines.h"
#include "base/rings.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

using haptics::Clock;
using haptics::LoopChannels;
using haptics::TickOutput;

namespace {

constexpr std::int64_t kSessionPeriod_ns = 2'000'000;
// Enough for the session thread to run once, unless the computer is overloaded.
constexpr int kCutPatience_ms = 20;
// Longer than any frame, even with software Vulkan.
constexpr std::int64_t kFrozen_ns = 3'000'000'000;

// True if something was cut between the two ticks, or may have been.
bool cutBetween(const TickOutput& a, const TickOutput& b) {
    return a.phase != b.phase || a.tissue != b.tissue || a.incision_count != b.incision_count;
}

// Passes states to show from the session to the frame loop. Neither side has a deadline, so a lock is
// sufficient.
class SeenQueue {
  public:
    void add(std::vector<Moment> moments, Seen newest) {
        const std::lock_guard lock(mutex_);
        newest_ = std::move(newest);
        for (Moment& m : moments)
            waiting_.push_back(std::move(m));
    }
    std::optional<Moment> next() {
        const std::lock_guard lock(mutex_);
        if (waiting_.empty()) return std::nullopt;
        Moment first = std::move(waiting_.front());
        waiting_.pop_front();
        return first;
    }
    // True if the session has not yet processed a cut that happened up to `tick`.
    bool lacksCutOf(const TickOutput& tick) {
        const std::lock_guard lock(mutex_);
        return newest_.tick.tick < tick.tick && cutBetween(newest_.tick, tick);
    }
    // The newest state with its tick replaced by a later one.
    Seen newest(const TickOutput& tick) {
        const std::lock_guard lock(mutex_);
        Seen at_tick = newest_;
        at_tick.tick = tick;
        return at_tick;
    }

  private:
    std::mutex mutex_;
    std::deque<Moment> waiting_;
    Seen newest_;
};

// Sends each command of the trace when its time has come and the ring has space.
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
    // True if a tick has consumed every command.
    bool done(const Ring<haptics::Command>& ring) const {
        return next_ == trace_.commands.size() && ring.empty();
    }

  private:
    const haptics::Trace& trace_;
    std::size_t next_ = 0;
};

std::int64_t durationOf(const haptics::Trace& trace) {
    return trace.samples.back().t_ns;
}

std::int64_t tickOf(const Attempt& attempt) {
    return std::llround(attempt.simulation.dt_s * 1e9);
}

// Time from which commands are still to be sent. A tick consumes the commands of its own time, so those of
// the last tick of the beginning were already sent.
std::int64_t givenBefore(const Attempt& attempt) {
    return attempt.beginning.empty() ? 0 : attempt.begun_ns() - tickOf(attempt) + 1;
}

// Computes the beginning (ticks of an earlier attempt), before the threads start. Returns the last tick.
TickOutput computeBeginning(const Attempt& attempt, haptics::Simulation& simulation, Session& session) {
    haptics::TickRecord record;
    haptics::NeedleEvents events;
    const auto step = [&](const haptics::TickInput& input) {
        record.input = input;
        simulation.step(record.input, record.output, events);
        session.take(record.input, record.output, events);
    };
    for (const haptics::TickInput& input : attempt.beginning)
        step(input);
    session.forgetNews();
    return record.output;
}

// Fades the force out as for a pause, so that the user takes over without force. These ticks belong to the
// attempt; the device rests and pedal and injection are off.
TickOutput letForceGo(const Attempt& attempt, haptics::Simulation& simulation, Session& session) {
    constexpr int kMost = 1000;
    haptics::TickRecord record;
    haptics::NeedleEvents events;
    record.input.device = attempt.beginning.back().device;
    record.input.device.fresh = 1;
    record.input.command_count = 3;
    record.input.commands[0] = {haptics::CommandKind::focus, 0};
    record.input.commands[1] = training::kPedalUp;
    record.input.commands[2] = {haptics::CommandKind::inject, 0};
    for (int i = 0; i < kMost; ++i) {
        simulation.step(record.input, record.output, events);
        session.take(record.input, record.output, events);
        record.input.command_count = 0;
        if (record.output.stage == haptics::ForceStage::off ||
            record.output.stage == haptics::ForceStage::waiting)
            break;
    }
    session.forgetNews();
    return record.output;
}

// Draws captures first, then the newest state. If pictures are lost it reports that once and continues
// without them.
class FrameSource {
  public:
    FrameSource(std::unique_ptr<Display> pictures, ContrastFeed& contrast)
        : pictures_(std::move(pictures)), contrast_feed_(&contrast) {}
    bool open() const { return pictures_ != nullptr; }
    Attention attention() const;
    bool askedToEnd() const { return asked_to_end_; }  // by the runtime
    void show(const Seen&, const std::string& moment);
    void close();  // ends the session and keeps the totals
    PictureTotals totals() const { return pictures_ ? pictures_->totals() : last_; }

  private:
    std::unique_ptr<Display> pictures_;
    ContrastFeed* contrast_feed_;
    patient::ContrastTable contrast_;
    PictureTotals last_;
    bool asked_to_end_ = false;
};

Attention FrameSource::attention() const {
    if (!pictures_) return Attention::absent;
    return pictures_->attention();
}

void FrameSource::show(const Seen& seen, const std::string& moment) {
    if (!pictures_) return;
    contrast_feed_->take(contrast_);
    try {
        if (pictures_->frame(seen, contrast_.revision > 0 ? &contrast_ : nullptr, moment)) return;
        asked_to_end_ = true;
        std::fprintf(stderr, "stylet: %s; the attempt continues without pictures\n", pictures_->endReason());
    } catch (const std::runtime_error& e) {
        std::fprintf(stderr, "stylet: pictures were lost: %s; the attempt continues without them\n",
                     e.what());
    }
    close();
}

void FrameSource::close() {
    if (!pictures_) return;
    last_ = pictures_->totals();
    pictures_.reset();
}

// Data shared with the frame thread. That thread may hang in the runtime forever and then outlives the
// attempt.
struct FrameSide {
    FrameSide(double dt_s, std::unique_ptr<Display> pictures, const Clock& clock_in)
        : channels(dt_s),
          worn(pictures != nullptr),
          clock(clock_in),
          frames(followed(std::move(pictures)), contrast) {}

    LoopChannels channels;
    SeenQueue seen;
    ContrastFeed contrast;
    const bool worn;
    const Clock clock;
    TickOutput latest;  // used by the frame thread only, like the next member
    bool begun = false;
    FrameSource frames;
    std::atomic<Attention> attention{worn ? Attention::absent : Attention::focused};
    std::atomic<std::int64_t> sign_ns{clock.now_ns(clock.context)};  // last sign of life of the frame thread
    std::atomic<bool> asked_to_end{false};                           // the runtime asked to end
    std::atomic<bool> ended{false};                                  // the attempt has ended
    std::exception_ptr failure;                                      // exception of the frame thread itself
    std::atomic<std::uint64_t> shown{0};
    std::promise<PictureTotals> totals;

    std::unique_ptr<Display> followed(std::unique_ptr<Display> pictures) {
        if (pictures)
            pictures->follow({&channels.tips, [this](Seen& seen_so_far) { seen_so_far = newestSeen(); },
                              [this](Attention now) { attention.store(now); }});
        return pictures;
    }
    // State at the newest tick. Waits shortly for the session, so that a cut appears together with its
    // wound.
    Seen newestSeen() {
        channels.latest.read(latest);
        for (int ms = 0; ms < kCutPatience_ms && seen.lacksCutOf(latest); ++ms)
            clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + 1'000'000);
        Seen now = seen.newest(latest);
        now.held = channels.paused.load(), now.to_return_m = channels.to_return_m.load();
        return now;
    }
    // Any thread. Reports `absent` if the picture is frozen: the user then no longer sees what is felt.
    Attention attentionNow() const {
        const bool frozen = worn && clock.now_ns(clock.context) - sign_ns.load() > kFrozen_ns;
        return frozen ? Attention::absent : attention.load();
    }
    // Draws the next capture or state. Returns false if there is nothing new.
    bool showNext() {
        begun = channels.latest.read(latest) || begun;
        if (const auto moment = seen.next(); moment && frames.open())
            frames.show(moment->seen, moment->name);
        else if (begun && frames.open() && !ended.load())
            frames.show(newestSeen(), "");
        else
            return moment.has_value();
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
            asked_to_end.store(frames.askedToEnd());
            if (drew) continue;
            if (last) break;
            clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + kSessionPeriod_ns);
        }
        frames.close();  // here, so that frame_patience_s also limits a hang in the runtime
    }
};

// The session thread: sends commands at their time and reads records, until trace and commands are finished
// or the user ends the attempt. The script's time is the loop's time, tick * dt, so it is used here too: a
// late loop is waited for.
void sessionLoop(const std::stop_token& stop, const Attempt& attempt, Session& session, FrameSide& side,
                 ForceFeed& force, const RealTimeOptions& options) {
    LoopChannels& channels = side.channels;
    const Clock& clock = side.clock;
    const std::int64_t dt_ns = tickOf(attempt), begun_ns = attempt.begun_ns();
    CommandFeed commands(attempt.hand, givenBefore(attempt));
    const std::uint64_t first = session.log().last_tick;  // of the beginning
    std::int64_t hand_ns = begun_ns;
    const auto over = [&] {
        return options.live
                   ? side.asked_to_end.load() || options.live->over(double(hand_ns - begun_ns) * 1e-9)
                   : (hand_ns >= durationOf(attempt.hand) && commands.done(channels.commands)) ||
                         (force.paused() && side.asked_to_end.load());  // nobody is left to resume it
    };
    while (!stop.stop_requested() && !over() && !force.next()) {
        commands.until(hand_ns, channels.commands);
        clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + kSessionPeriod_ns);
        session.drain(channels);
        const Attention attention = side.attentionNow();
        force.pass(attention == Attention::focused, session, channels.commands);
        channels.pause.store(attention == Attention::away || force.paused());
        Seen now = session.seen(session.newest() ? *session.newest() : TickOutput{});
        now.held = channels.paused.load();
        now.paused = force.paused();
        if (options.heard && session.newest()) options.heard(now);
        side.seen.add(session.newMoments(), std::move(now));
        if (side.worn) side.contrast.give(session.contrast());
        hand_ns = begun_ns + std::int64_t(session.log().last_tick - first) * dt_ns;
    }
}

// Returns the picture totals after the last frame. Returns nothing if no frame completes within
// `frame_patience_s`.
std::optional<PictureTotals> lastPictures(FrameSide& side, double frame_patience_s) {
    const std::chrono::duration<double> patience(frame_patience_s);
    auto totals = side.totals.get_future();
    for (std::uint64_t before = side.shown.load();; before = side.shown.load()) {
        if (totals.wait_for(patience) == std::future_status::ready) return totals.get();
        if (side.shown.load() == before) return std::nullopt;
    }
}

// Exits without destroying anything, because a stuck thread still uses it.
[[noreturn]] void leaveAtOnce(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet: %s\n", e.what());
    }
    std::fflush(nullptr);
    std::_Exit(2);
}

}  // namespace

LoopTotals runRealTime(const Attempt& attempt, Session& session, std::unique_ptr<Display> pictures,
                       const Clock& clock, const RealTimeOptions& options) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap());
    const auto side = std::make_shared<FrameSide>(attempt.simulation.dt_s, std::move(pictures), clock);
    LoopChannels& channels = side->channels;
    LoopTotals totals;
    // A real user takes over as after a pause. A script continues without interruption.
    const bool resumes = !attempt.beginning.empty() && (options.live || side->worn);
    if (!attempt.beginning.empty()) {
        TickOutput newest = computeBeginning(attempt, simulation, session);
        if (resumes) newest = letForceGo(attempt, simulation, session);
        channels.paused.store(resumes);
        channels.latest.publish(newest);
        side->seen.add(session.newMoments(), session.seen(newest));
    } else if (side->worn) {
        channels.commands.push({haptics::CommandKind::focus, 0});
    }
    const bool focused = !side->worn && simulation.state().output.safety.focused;
    std::exception_ptr failure;

    // If something throws here, each thread is asked to stop and joined.
    std::jthread haptics_thread([&](const std::stop_token& stop) {
        const std::stop_callback stopped(stop, [&] { channels.stop.store(true); });
        const std::string refused = askForRealTime();
        if (!refused.empty()) std::fprintf(stderr, "stylet: %s\n", refused.c_str());
        const std::int64_t begin_ns = clock.now_ns(clock.context);
        haptics::ReplayDevice scripted(attempt.hand, -attempt.begun_ns(), attempt.simulation.profile);
        haptics::HapticDevice& device = options.live ? options.live->device : scripted;
        totals.haptics = runLoop(simulation, device, channels, clock);
        totals.elapsed_s = double(clock.now_ns(clock.context) - begin_ns) * 1e-9;
    });
    std::jthread session_thread([&](const std::stop_token& stop) {
        try {
            ForceFeed force(focused, attempt.simulation.dt_s, options.live, sayOnStderr, options.console,
                            resumes);
            sessionLoop(stop, attempt, session, *side, force, options);
            totals.next = force.next();
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
    totals.flights_missed = channels.flights.missed();
    if (!failure) try {
            session.drain(channels);
            side->seen.add(session.newMoments(), session.seen({}));
            if (side->worn) side->contrast.give(session.contrast());
        } catch (...) {
            failure = std::current_exception();
        }
    side->ended.store(true);
    if (auto last = lastPictures(*side, options.frame_patience_s)) {
        totals.pictures = std::move(*last);
        frame_thread.join();
        if (!failure) failure = side->failure;
    } else {
        totals.frames_stuck = true;
        frame_thread.detach();
        if (failure) leaveAtOnce(failure);
    }
    if (failure) std::rethrow_exception(failure);
    return totals;
}

LoopTotals runFast(const Attempt& attempt, Session& session, std::unique_ptr<Display> pictures, double fps,
                   const Clock& clock) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap());
    haptics::ReplayDevice device(attempt.hand, 0, attempt.simulation.profile);
    LoopChannels channels(attempt.simulation.dt_s);
    LoopTotals totals;
    CommandFeed commands(attempt.hand, givenBefore(attempt));
    ContrastFeed contrast;
    FrameSource frames(std::move(pictures), contrast);
    const std::int64_t dt_ns = tickOf(attempt);
    double next_frame_s = double(attempt.begun_ns()) * 1e-9;
    TickOutput latest;
    if (!attempt.beginning.empty()) computeBeginning(attempt, simulation, session);
    ForceFeed force(simulation.state().output.safety.focused, attempt.simulation.dt_s);
    for (std::int64_t now_ns = attempt.begun_ns();
         now_ns <= durationOf(attempt.hand) || !commands.done(channels.commands); now_ns += dt_ns) {
        commands.until(now_ns, channels.commands);
        loopTick(simulation, device, channels, totals.haptics, now_ns, {clock});
        session.drain(channels);
        force.pass(true, session, channels.commands);
        for (const Moment& moment : session.newMoments()) {
            contrast.give(session.contrast());
            frames.show(moment.seen, moment.name);
        }
        if (!frames.open() || fps <= 0.0 || double(now_ns) * 1e-9 < next_frame_s) continue;
        channels.latest.read(latest);
        contrast.give(session.contrast());
        frames.show(session.seen(latest), "");
        next_frame_s += 1.0 / fps;
    }
    channels.flights.finish();
    totals.flights_missed = channels.flights.missed();
    session.drain(channels);
    totals.elapsed_s = double(totals.haptics.ticks) * attempt.simulation.dt_s;
    totals.pictures = frames.totals();
    return totals;
}

}  // namespace stylet::trainer
