#include "haptics/loop.h"

#include <cmath>

namespace stylet::haptics {

void loopTick(Simulation& simulation, HapticDevice& device, LoopChannels& channels, LoopStats& stats,
              std::int64_t t_ns, const Clock& clock, std::int64_t due_ns) noexcept {
    TickRecord record;
    record.input.device = device.read(t_ns);
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
    // The frame loop sees what the record cannot hold: that it has a gap.
    record.output.faults |= stats.faults & kFaultRingFull;
    channels.latest.publish(record.output);
    channels.flights.log(record);
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
        loopTick(simulation, device, channels, stats, std::int64_t(stats.ticks) * period_ns, clock, due_ns);
        if (stats.ticks == warm_up) faults_before = pageFaults();
        deadline_ns += period_ns;
        clock.sleepUntil_ns(clock.context, deadline_ns);
    }
    if (stats.ticks > warm_up) stats.page_faults = pageFaults() - faults_before;
    return stats;
}

}  // namespace stylet::haptics
