// The 1 kHz loop around Simulation::step: device in, force out, rings and snapshot to the session.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "haptics/device.h"
#include "haptics/flight_recorder.h"
#include "haptics/rings.h"
#include "haptics/simulation.h"

namespace stylet::haptics {

// The loop's only access to time, given by app/. All are called on the haptics thread.
struct Clock {
    void* context = nullptr;
    std::int64_t (*now_ns)(void* context) noexcept = nullptr;
    void (*sleepUntil_ns)(void* context, std::int64_t t_ns) noexcept = nullptr;
    // Of the calling thread so far; may be absent.
    std::uint64_t (*pageFaults)(void* context) noexcept = nullptr;
};

struct EventRecord {
    std::uint64_t tick = 0;
    NeedleEvent event;
};

// Where the thing in hand was: what pictures are taken ahead from and measured against.
struct TipSample {
    std::int64_t t_ns = 0;  // by the loop's clock, as the device was read; without a clock the loop's time
    std::uint64_t tick = 0;
    Tool tool = Tool::needle;
    bool fresh = false;     // the device said something new
    bool parked = false;    // the probe is
    Pose patient_from_tip;  // of a needle in the guide: on its rail
    Vec3 probe_m{0.0};      // the parked probe's face
};

struct LoopStats {
    std::uint64_t ticks = 0, late_ticks = 0;  // late: the force was sent after the next tick's deadline
    std::uint64_t held = 0;                   // periods without a tick, see LoopChannels::hold
    bool unseen = false;                      // of these: the device moved, and no tick has seen it yet
    double max_step_us = 0.0;                 // of step() alone, device I/O not counted
    std::uint32_t faults = 0;                 // every bit ever seen
    std::uint64_t page_faults = 0;            // after the first kWarmUp_s
};
inline constexpr double kWarmUp_s = 0.5;

struct LoopChannels {
    explicit LoopChannels(double dt_s = 0.001) : flights(dt_s) {}

    Ring<Command> commands{64};      // session -> haptics
    Ring<TickRecord> records{4096};  // haptics -> session
    Ring<EventRecord> events{1024};  // haptics -> session
    Snapshot<TickOutput> latest;     // haptics -> frame loop
    FlightRecorder flights;          // haptics -> session, after a fault
    Ring<TipSample> tips{4096};      // haptics -> frame loop, or nobody: full is no fault
    std::atomic<bool> stop{false};

    // A pause, set by the session: once the force is gone the device is still read and sent zero every
    // period, but there are no ticks, so that nothing is felt, recorded or hashed and the patient's time
    // stands. Cleared, the ticks go on where they stopped. A needle in the body stays where it was let go of:
    // they then wait until the hand is back within kHandBack_m, `to_return_m` telling how far that is.
    std::atomic<bool> hold{false};
    std::atomic<bool> held{false};  // set by the loop: it makes no ticks
    std::atomic<double> to_return_m{0.0};
};
inline constexpr double kHandBack_m = 0.003;
inline constexpr double kNotThere_m = 1e3;  // LoopChannels::to_return_m of a device that is not there

// One tick: reads the device, takes the commands waiting, steps, sends, publishes. `t_ns` is the loop's time,
// tick * dt from its start. With a clock the step is timed, and late when its force is sent after `due_ns` of
// that clock. Haptics thread. noexcept, no allocation, no lock.
inline constexpr std::int64_t kNeverDue_ns = std::numeric_limits<std::int64_t>::max();
void loopTick(Simulation&, HapticDevice&, LoopChannels&, LoopStats&, std::int64_t t_ns,
              const Clock& clock = {}, std::int64_t due_ns = kNeverDue_ns) noexcept STYLET_NONBLOCKING;

// A period of a pause in a tick's place; false when the tick is due. Haptics thread, as loopTick().
bool loopHold(const Simulation&, HapticDevice&, LoopChannels&, LoopStats&,
              std::int64_t t_ns) noexcept STYLET_NONBLOCKING;

// Ticks at absolute deadlines until `stop`. A late tick is counted, never stretched or made up: the deadlines
// it slept through are gone, and the loop's time stays tick * dt behind its start.
LoopStats runLoop(Simulation&, HapticDevice&, LoopChannels&, const Clock&) noexcept;

}  // namespace stylet::haptics
