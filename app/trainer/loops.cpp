#include "app/trainer/loops.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>

#include "app/trainer/force_feed.h"
#include "app/trainer/platform_linux.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

using haptics::Clock;
using haptics::LoopChannels;
using haptics::TickOutput;

namespace {

constexpr std::int64_t kSessionPeriod_ns = 2'000'000;

// Moments on their way from the session to the frame loop. Neither side has a deadline, so a lock will do.
class MomentQueue {
  public:
    void add(std::vector<Moment> moments) {
        const std::lock_guard lock(mutex_);
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

  private:
    std::mutex mutex_;
    std::deque<Moment> waiting_;
};

// The trace's commands, each handed over once its time has come and the ring has room.
class CommandFeed {
  public:
    explicit CommandFeed(const haptics::Trace& trace) : trace_(trace) {}
    void until(std::int64_t t_ns, haptics::Ring<haptics::Command>& ring) {
        while (next_ < trace_.commands.size() && trace_.commands[next_].t_ns <= t_ns &&
               ring.push(trace_.commands[next_].command))
            ++next_;
    }
    // Every command has been taken by a tick.
    bool done(const haptics::Ring<haptics::Command>& ring) const {
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

// The session's thread: commands out at their time, records in, until hand and commands have come to their
// end, or the user to his. The hand moves with the loop's time, tick * dt, so that is what counts here too: a
// late loop is waited for.
void sessionLoop(const std::stop_token& stop, const Attempt& attempt, Session& session,
                 LoopChannels& channels, MomentQueue& moments, ForceFeed force,
                 const std::atomic<bool>& focused, const Clock& clock, const LiveHand* live) {
    CommandFeed commands(attempt.hand);
    const std::int64_t dt_ns = tickOf(attempt);
    std::int64_t hand_ns = 0;
    const auto over = [&] {
        return live ? live->over(double(hand_ns) * 1e-9)
                    : hand_ns >= durationOf(attempt.hand) && commands.done(channels.commands);
    };
    while (!stop.stop_requested() && !over()) {
        commands.until(hand_ns, channels.commands);
        clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + kSessionPeriod_ns);
        session.drain(channels);
        force.pass(focused.load(), session, channels.commands);
        moments.add(session.newMoments());
        hand_ns = std::int64_t(session.log().last_tick) * dt_ns;
    }
}

}  // namespace

void FrameSource::show(const TickOutput& shown, const std::string& moment) {
    if (!pictures_) return;
    try {
        if (pictures_->frame(shown, moment)) return;
        std::fprintf(stderr,
                     "stylet: the OpenXR runtime ended the session; the attempt goes on without pictures\n");
    } catch (const std::runtime_error& e) {
        std::fprintf(stderr, "stylet: pictures were lost: %s; the attempt goes on without them\n", e.what());
    }
    close();
}

void FrameSource::close() {
    last_ = pictures_->totals();
    pictures_.reset();
}

LoopTotals runRealTime(const Attempt& attempt, Session& session, std::optional<Pictures> pictures,
                       const Clock& clock, const LiveHand* live) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap());
    LoopChannels channels(attempt.simulation.dt_s);
    MomentQueue moments;
    LoopTotals totals;
    std::atomic<bool> ended{false};
    const bool worn = pictures.has_value();
    std::atomic<bool> focused{!worn};
    if (worn) channels.commands.push({haptics::CommandKind::focus, 0});
    std::exception_ptr failure;

    // When something throws here, each thread is told to stop, then joined.
    std::jthread haptics_thread([&](const std::stop_token& stop) {
        const std::stop_callback stopped(stop, [&] { channels.stop.store(true); });
        const std::string refused = askForRealTime();
        if (!refused.empty()) std::fprintf(stderr, "stylet: %s\n", refused.c_str());
        const std::int64_t begin_ns = clock.now_ns(clock.context);
        haptics::ReplayDevice scripted(attempt.hand, 0, attempt.simulation.profile);
        haptics::HapticDevice& device = live ? live->device : scripted;
        totals.haptics = runLoop(simulation, device, channels, clock);
        totals.elapsed_s = double(clock.now_ns(clock.context) - begin_ns) * 1e-9;
    });
    std::jthread session_thread([&](const std::stop_token& stop) {
        try {
            sessionLoop(stop, attempt, session, channels, moments,
                        ForceFeed(!worn, attempt.simulation.dt_s, live), focused, clock, live);
        } catch (...) {
            failure = std::current_exception();
        }
        channels.stop.store(true);
        ended.store(true);
    });

    FrameSource frames(std::move(pictures));
    TickOutput latest;
    bool begun = false;
    while (!ended.load()) {
        begun = channels.latest.read(latest) || begun;
        if (const auto moment = moments.next(); moment && frames.open())
            frames.show(moment->shown, moment->name);
        else if (begun && frames.open())
            frames.show(latest, "");
        else
            clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + kSessionPeriod_ns);
        focused.store(!worn || frames.focused());
    }
    session_thread.join();
    haptics_thread.join();
    channels.flights.finish();
    totals.flights_missed = channels.flights.missed();
    if (failure) std::rethrow_exception(failure);
    session.drain(channels);
    moments.add(session.newMoments());
    while (const auto moment = moments.next())
        frames.show(moment->shown, moment->name);
    totals.pictures = frames.totals();
    return totals;
}

LoopTotals runFast(const Attempt& attempt, Session& session, std::optional<Pictures> pictures, double fps,
                   const Clock& clock) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap());
    haptics::ReplayDevice device(attempt.hand, 0, attempt.simulation.profile);
    LoopChannels channels(attempt.simulation.dt_s);
    LoopTotals totals;
    CommandFeed commands(attempt.hand);
    ForceFeed force(true, attempt.simulation.dt_s);
    FrameSource frames(std::move(pictures));
    const std::int64_t dt_ns = tickOf(attempt);
    double next_frame_s = 0.0;
    TickOutput latest;
    for (std::int64_t now_ns = 0; now_ns <= durationOf(attempt.hand) || !commands.done(channels.commands);
         now_ns += dt_ns) {
        commands.until(now_ns, channels.commands);
        loopTick(simulation, device, channels, totals.haptics, now_ns, clock);
        session.drain(channels);
        force.pass(true, session, channels.commands);
        for (const Moment& moment : session.newMoments())
            frames.show(moment.shown, moment.name);
        if (!frames.open() || fps <= 0.0 || double(now_ns) * 1e-9 < next_frame_s) continue;
        channels.latest.read(latest);
        frames.show(latest, "");
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
