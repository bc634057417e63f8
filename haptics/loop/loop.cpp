#include "haptics/loop/loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stylet::haptics {

namespace {

TipSample makeTipSample(const TickRecord& record, std::int64_t read_ns) noexcept {
    const TickOutput& out = record.output;
    return {.t_ns = read_ns,
            .tick = out.tick,
            .tool = out.tool,
            .fresh = record.input.device.fresh != 0,
            .parked = out.probe_parked,
            .patient_from_tip = isNeedleTool(out.tool) ? out.patient_from_needle : out.patient_from_tool,
            .probe_m = out.patient_from_probe.position_m};
}

// Distance the stylus must still return before a pause can end.
double computeReturnDistance_m(const Simulation& simulation, const DeviceState& device) noexcept {
    const SimulationState& s = simulation.state();
    if (s.tools.needle.phase == Phase::outside) return 0.0;
    if ((device.flags & kDeviceReady) == 0 || !isPose(device.device_from_stylus)) return kDeviceNotReady_m;
    const Pose& patient_from_device = simulation.settings().patient_from_device;
    const double away = glm::length((patient_from_device * device.device_from_stylus).position_m -
                                    s.patient_moved_m - s.patient_from_stylus.position_m);
    return away > kResumeDistance_m ? away : 0.0;
}

}  // namespace

void loopTick(Simulation& simulation, HapticDevice& device, LoopChannels& channels, LoopStats& stats,
              std::int64_t t_ns, const TickTiming& timing) noexcept {
    const auto& [clock, due_ns] = timing;
    TickRecord record;
    const std::int64_t read_ns = clock.now_ns ? clock.now() : t_ns;
    record.input.device = device.read(t_ns);
    // Otherwise motion during the pause would be lost.
    if (std::exchange(stats.moved_during_pause, false)) record.input.device.fresh = 1;
    while (record.input.command_count < std::uint32_t(kMaxCommandsPerTick) &&
           channels.commands.pop(record.input.commands[record.input.command_count]))
        ++record.input.command_count;

    NeedleEvents events;
    const std::int64_t began_ns = clock.now_ns ? clock.now() : 0;
    simulation.step(record.input, record.output, events);
    if (clock.now_ns) stats.max_step_us = std::max(stats.max_step_us, double(clock.now() - began_ns) * 1e-3);
    device.send(record.output.sent_device_n);
    if (clock.now_ns && clock.now() > due_ns) ++stats.late_ticks;

    bool whole = channels.records.push(record) && events.dropped == 0;
    for (const NeedleEvent& event : events.all())
        whole = channels.events.push({record.output.tick, event}) && whole;
    ++stats.ticks;
    stats.faults |= record.output.faults | (whole ? 0u : std::uint32_t(kFaultRingFull));
    // The record cannot show its own gap, so the output for the frame loop reports it.
    record.output.faults |= stats.faults & kFaultRingFull;
    // Push before publish: a reader of the newest tick then finds its sample in `tips`.
    channels.tips.push(makeTipSample(record, read_ns));
    channels.latest.publish(record.output);
    channels.flights.log(record);
}

bool loopPausedPeriod(const Simulation& simulation, HapticDevice& device, LoopChannels& channels,
                      LoopStats& stats, std::int64_t t_ns) noexcept {
    const ForceStage stage = simulation.state().output.safety.stage;
    const bool forceless = stage == ForceStage::off || stage == ForceStage::waiting;
    const bool was_paused = channels.paused.load(std::memory_order_relaxed);
    const bool requested = channels.pause.load(std::memory_order_acquire);
    bool pauses = requested && forceless;
    if (pauses || was_paused) {
        const DeviceState state = device.read(t_ns);
        stats.moved_during_pause = stats.moved_during_pause || state.fresh != 0;
        const double return_distance_m = computeReturnDistance_m(simulation, state);
        pauses = pauses || return_distance_m > 0.0;
        channels.return_distance_m.store(pauses ? return_distance_m : 0.0, std::memory_order_relaxed);
    }
    if (pauses) {
        device.send(Vec3(0.0));
        ++stats.paused;
    }
    if (pauses != was_paused) channels.paused.store(pauses, std::memory_order_release);
    return pauses;
}

LoopStats runLoop(Simulation& simulation, HapticDevice& device, LoopChannels& channels,
                  const Clock& clock) noexcept {
    const std::int64_t period_ns = std::llround(simulation.settings().dt_s * 1e9);
    std::int64_t deadline_ns = clock.now();
    const std::uint64_t warm_up = std::uint64_t(kWarmUp_s / simulation.settings().dt_s);
    const auto pageFaults = [&] { return clock.pageFaults ? clock.pageFaults(clock.context) : 0; };
    std::uint64_t faults_before = 0;
    LoopStats stats;
    while (!channels.stop.load(std::memory_order_acquire)) {
        const std::int64_t due_ns = deadline_ns + period_ns;
        const std::int64_t late_ns = clock.now() - deadline_ns;
        if (late_ns > period_ns) deadline_ns += late_ns / period_ns * period_ns;
        const std::int64_t t_ns = std::int64_t(stats.ticks) * period_ns;
        if (!loopPausedPeriod(simulation, device, channels, stats, t_ns))
            loopTick(simulation, device, channels, stats, t_ns, {clock, due_ns});
        if (stats.ticks == warm_up) faults_before = pageFaults();
        deadline_ns += period_ns;
        clock.sleepUntil(deadline_ns);
    }
    if (stats.ticks > warm_up) stats.page_faults = pageFaults() - faults_before;
    return stats;
}

}  // namespace stylet::haptics
