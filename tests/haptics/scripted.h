// A scripted puncture of a small breathing patient. Shared by the tests of the tick, the loop and the
// allocator.
#pragma once

#include "haptics/haptics.h"
#include "tests/haptics/along_x.h"
#include "tests/haptics/column.h"

namespace stylet::test {

inline patient::Package scriptedPackage() {
    using enum patient::Tissue;
    patient::Package package = makeColumn(
        {{skin, 0.002}, {soft, 0.012}, {fascia, 0.001}, {liver, 0.02}, {duct, 0.004}, {liver, 0.01}});
    addBreathing(package, -0.012);
    return package;
}

// Moves in by 42 mm in 3 s, rests for 1 s, moves out in 2 s, and sways sideways all the time.
inline haptics::Trace scriptedTrace() {
    haptics::Trace trace;
    const auto at = [&](double t_s, double x_m, double z_m) {
        trace.samples.push_back({std::int64_t(t_s * 1e9), {kAlongX, {x_m, 0.0003, z_m}}, 0});
    };
    at(0.0, -0.006, 0.0), at(3.0, 0.036, 0.002), at(4.0, 0.036, -0.004), at(6.0, -0.006, 0.0);
    return trace;
}

// Input of tick `i`: requests a breath hold at 0.2 s and normal breathing at 3.5 s.
inline haptics::TickInput scriptedInput(const haptics::Trace& trace, int i) {
    std::size_t cursor = 0;
    const haptics::TraceSample sample = haptics::sampleAt(trace, std::int64_t(i) * 1000000, cursor);
    haptics::TickInput input;
    input.device = {sample.device_from_stylus, sample.buttons, 1};
    if (i == 200) input.commands[input.command_count++] = {haptics::CommandKind::holdBreath, 0};
    if (i == 3500) input.commands[input.command_count++] = {haptics::CommandKind::breathe, 0};
    return input;
}
inline constexpr int kScriptedTicks = 6000;

}  // namespace stylet::test
