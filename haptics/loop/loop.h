// The 1 kHz loop around Simulation::step: reads the device, sends the force, and passes records and events
// to the session through rings and a snapshot.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "base/rings.h"
#include "haptics/loop/flight_recorder.h"
#include "haptics/loop/simulation.h"
#include "haptics/tools/device.h"

namespace stylet::haptics {

// The loop's only access to time, supplied by app/. All functions are called on the haptics thread.
struct Clock {
    void* context = nullptr;
    std::int64_t (*now_ns)(void* context) noexcept = nullptr;
    void (*sleepUntil_ns)(void* context, std::int64_t t_ns) noexcept = nullptr;
    // Page faults of the calling thread so far. May be null.
    std::uint64_t (*pageFaults)(void* context) noexcept = nullptr;

    std::int64_t now() const noexcept { return now_ns(context); }
    void sleepUntil(std::int64_t t_ns) const noexcept { sleepUntil_ns(context, t_ns); }
};

struct EventRecord {
    std::uint64_t tick = 0;
    NeedleEvent event;
};

// Pose of the active tool. Rendering predicts from it, and latency is measured against it.
struct TipSample {
    std::int64_t t_ns = 0;  // clock time when the device was read; without a clock, the loop's time
    std::uint64_t tick = 0;
    Tool tool = Tool::needle;
    bool fresh = false;     // the device delivered a new state
    bool parked = false;    // the probe is parked
    Pose patient_from_tip;  // for a needle in the guide: on the rail
    Vec3 probe_m{0.0};      // face of the parked probe
};

struct LoopStats {
    std::uint64_t ticks = 0, late_ticks = 0;  // late: the force was sent after the next tick's deadline
    std::uint64_t paused = 0;                 // paused periods without a tick, see LoopChannels::pause
    // The device moved during a pause and no tick has seen the motion yet.
    bool moved_during_pause = false;
    double max_step_us = 0.0;       // of step() alone, without device I/O
    std::uint32_t faults = 0;       // every fault bit ever set
    std::uint64_t page_faults = 0;  // after the first kWarmUp_s
};
inline constexpr double kWarmUp_s = 0.5;

struct LoopChannels {
    explicit LoopChannels(double dt_s = 0.001) : flights(dt_s) {}

    Ring<Command> commands{64};      // session -> haptics
    Ring<TickRecord> records{4096};  // haptics -> session
    Ring<EventRecord> events{1024};  // haptics -> session
    Snapshot<TickOutput> latest;     // haptics -> frame loop
    FlightRecorder flights;          // haptics -> session, after a fault
    Ring<TipSample> tips{4096};      // haptics -> frame loop; may be unread, a full ring is no fault
    std::atomic<bool> stop{false};

    // Pauses the loop; set by the session. Once the force is zero, the loop still reads the device and sends
    // zero every period, but makes no ticks: nothing is felt, recorded or hashed, and the patient's time
    // stands still. When cleared, ticks resume where they stopped. If the needle is in the body, it stays
    // where it was, and ticks resume only when the stylus is back within kResumeDistance_m of it.
    // `return_distance_m` is the remaining distance.
    std::atomic<bool> pause{false};
    std::atomic<bool> paused{false};  // set by the loop: paused, no ticks
    std::atomic<double> return_distance_m{0.0};
};
inline constexpr double kResumeDistance_m = 0.003;
inline constexpr double kDeviceNotReady_m =
    1e3;  // LoopChannels::return_distance_m when the device is not ready

// Timing of a tick. Without a clock nothing is measured.
struct TickTiming {
    Clock clock;
    std::int64_t due_ns = std::numeric_limits<std::int64_t>::max();  // deadline for sending the force
};

// One tick: reads the device, pops the waiting commands, steps the simulation, sends the force, publishes.
// `t_ns` is the loop's time, tick * dt since its start. With a clock the step is timed, and the tick counts
// as late if its force is sent after `due_ns` on that clock. Haptics thread. noexcept, no allocation, no
// lock.
void loopTick(Simulation&, HapticDevice&, LoopChannels&, LoopStats&, std::int64_t t_ns,
              const TickTiming& = {}) noexcept STYLET_NONBLOCKING;

// One paused period in place of a tick. Returns false if a tick is due. Haptics thread, like loopTick().
bool loopPausedPeriod(const Simulation&, HapticDevice&, LoopChannels&, LoopStats&,
                      std::int64_t t_ns) noexcept STYLET_NONBLOCKING;

// Runs ticks at absolute deadlines until `stop`. A late tick is counted; its dt is not stretched, and missed
// deadlines are skipped. The loop's time is the number of ticks * dt, so it falls behind the clock.
LoopStats runLoop(Simulation&, HapticDevice&, LoopChannels&, const Clock&) noexcept;

}  // namespace stylet::haptics
