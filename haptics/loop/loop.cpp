#include "haptics/loop/loop.h"

#include <cmath>
#include <utility>

namespace stylet::haptics {

namespace {

TipSample tipOf(const TickRecord& record, std::int64_t read_ns) noexcept {
    const TickOutput& out = record.output;
    return {.t_ns = read_ns,
            .tick = out.tick,
            .tool = out.tool,
            .fresh = record.input.device.fresh != 0,
            .parked = out.probe_parked,
            .patient_from_tip = holdsNeedle(out.tool) ? out.patient_from_needle : out.patient_from_tool,
            .probe_m = out.patient_from_probe.position_m};
}

// Distance the stylus must still return before a pause can end.
double toReturn_m(const Simulation& simulation, const DeviceState& device) noexcept {
    const SimulationState& s = simulation.state();
    if (s.tools.needle.phase == Phase::outside) return 0.0;
    if ((device.flags & kDeviceReady) == 0 || !isPose(device.device_from_stylus)) return kNotThere_m;
    const Pose& patient_from_device = simulation.settings().patient_from_device;
    const Vec3 away_m = (patient_from_device * device.device_from_stylus).position_m - s.patient_moved_m -
                        s.patient_from_stylus.position_m;
    const double away = std::sqrt(glm::dot(away_m, away_m));
    return away > kHandBack_m ? away : 0.0;
}

}  // namespace

void loopTick(Simulation& simulation, HapticDevice& device, LoopChannels& channels, LoopStats& stats,
              std::int64_t t_ns, const TickTiming& timing) noexcept {
    const auto& [clock, due_ns] = timing;
    TickRecord record;
    const std::int64_t read_ns = clock.now_ns ? clock.now_ns(clock.context) : t_ns;
    record.input.device = device.read(t_ns);
    // Otherwise motion during the pause would be lost.
    if (std::exchange(stats.unseen, false)) record.input.device.fresh = 1;
    while (record.input.command_count < std::uint32_t(kMaxCommandsPerTick) &&
           channels.commands.pop(record.input.commands[record.input.command_count])) {
        ++record.input.command_count;
    }

    NeedleEvents events;
    const std::int64_t began_ns = clock.now_ns ? clock.now_ns(clock.context) : 0;
    simulation.step(record.input, record.output, events);
    if (clock.now_ns) {
        const double step_us = double(clock.now_ns(clock.context) - began_ns) * 1e-3;
        if (step_us > stats.max_step_us) stats.max_step_us = step_us;
    }
    device.send(record.output.sent_device_n);
    if (clock.now_ns && clock.now_ns(clock.context) > due_ns) ++stats.late_ticks;

    bool whole = channels.records.push(record) && events.dropped == 0;
    for (int i = 0; i < events.count; ++i) {
        whole = channels.events.push({record.output.tick, events.list[std::size_t(i)]}) && whole;
    }
    ++stats.ticks;
    stats.faults |= record.output.faults | (whole ? 0u : std::uint32_t(kFaultRingFull));
    // The record cannot show its own gap, so the output for the frame loop reports it.
    record.output.faults |= stats.faults & kFaultRingFull;
    // Push before publish: a reader of the newest tick then finds its sample in `tips`.
    channels.tips.push(tipOf(record, read_ns));
    channels.latest.publish(record.output);
    channels.flights.log(record);
}

bool loopPaused(const Simulation& simulation, HapticDevice& device, LoopChannels& channels, LoopStats& stats,
                std::int64_t t_ns) noexcept {
    const ForceStage stage = simulation.state().output.safety.stage;
    const bool forceless = stage == ForceStage::off || stage == ForceStage::waiting;
    const bool was_paused = channels.paused.load(std::memory_order_relaxed);
    const bool requested = channels.pause.load(std::memory_order_acquire);
    bool pauses = requested && forceless;
    if (pauses || was_paused) {
        const DeviceState state = device.read(t_ns);
        stats.unseen = stats.unseen || state.fresh != 0;
        const double to_return_m = toReturn_m(simulation, state);
        pauses = pauses || to_return_m > 0.0;
        channels.to_return_m.store(pauses ? to_return_m : 0.0, std::memory_order_relaxed);
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
    std::int64_t deadline_ns = clock.now_ns(clock.context);
    const std::uint64_t warm_up = std::uint64_t(kWarmUp_s / simulation.settings().dt_s);
    const auto pageFaults = [&] { return clock.pageFaults ? clock.pageFaults(clock.context) : 0; };
    std::uint64_t faults_before = 0;
    LoopStats stats;
    while (!channels.stop.load(std::memory_order_acquire)) {
        const std::int64_t due_ns = deadline_ns + period_ns;
        const std::int64_t late_ns = clock.now_ns(clock.context) - deadline_ns;
        if (late_ns > period_ns) deadline_ns += late_ns / period_ns * period_ns;
        const std::int64_t t_ns = std::int64_t(stats.ticks) * period_ns;
        if (!loopPaused(simulation, device, channels, stats, t_ns))
            loopTick(simulation, device, channels, stats, t_ns, {clock, due_ns});
        if (stats.ticks == warm_up) faults_before = pageFaults();
        deadline_ns += period_ns;
        clock.sleepUntil_ns(clock.context, deadline_ns);
    }
    if (stats.ticks > warm_up) stats.page_faults = pageFaults() - faults_before;
    return stats;
}

}  // namespace stylet::haptics
