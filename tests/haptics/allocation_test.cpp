// Counts allocations in 10,000 ticks with a replaced operator new. There must be none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/devices/replay.h"
#include "tests/haptics/scripted.h"
#include "tests/haptics/simulation_bench.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

// A breathing plan with every kind of irregularity, optionally recorded.
patient::BreathPlan restless() {
    patient::BreathPlan plan{.rhythm = {1.0, 1.0}};
    plan.period_jitter = plan.depth_jitter = 0.1;
    plan.sighs = plan.coughs = 0.2;
    plan.hold = {-0.3, 24.0, 0.2, 0.1, 2.0};
    return plan;
}
patient::BreathPlan recorded() {
    patient::BreathPlan plan;
    plan.recording_v = {0.0, 0.1, 0.3, 0.6, 0.9, 1.0, 0.8, 0.5, 0.3, 0.1};
    return plan;
}

class Allocation : public testing::TestWithParam<patient::BreathPlan> {};
INSTANTIATE_TEST_SUITE_P(Breaths, Allocation, testing::Values(patient::BreathPlan{}, restless(), recorded()));

// HZ-FORCE-18
TEST_P(Allocation, TenThousandTicksAllocateNothing) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    const Trace trace = test::scriptedTrace();
    SimulationSettings settings;
    settings.breath = GetParam();
    Simulation simulation(patient, settings);
    ReplayDevice device(trace, 0);
    LoopChannels channels;
    LoopStats stats;
    TickRecord record;
    int punctures = 0;
    EventRecord event;

    const std::uint64_t before = test::allocations();
    for (int i = 0; i < 10000; ++i) {
        loopTick(simulation, device, channels, stats, std::int64_t(i % test::kScriptedTicks) * 1000000);
        channels.records.pop(record);
        while (channels.events.pop(event))
            punctures += event.event.kind == NeedleEventKind::puncture;
    }
    channels.pause.store(true);
    channels.commands.push({CommandKind::focus, 0});
    for (int i = 0; i < 1000; ++i) {
        if (!loopPausedPeriod(simulation, device, channels, stats, 0))
            loopTick(simulation, device, channels, stats, 0);
    }
    EXPECT_GT(stats.paused, 900u);
    EXPECT_EQ(test::allocations() - before, 0u);
    EXPECT_GE(punctures, 3);

    // Checks that the counter works. Calls the operators directly, because the compiler may remove a
    // new-expression and its delete.
    ::operator delete(::operator new(4));
    EXPECT_EQ(test::allocations() - before, 1u);
}

// HZ-FORCE-18
TEST(Allocation, WireDilatorAndDrainAllocateNothing) {
    using enum patient::Tissue;
    const patient::Package package =
        test::makeSlabs({{skin, 0.002}, {liver, 0.010}, {duct, 0.060}, {liver, 0.010}}, 0.001);
    const patient::Patient patient(package);
    const patient::DuctSpace ducts = patient::makeDuctSpace(patient);
    Simulation simulation(patient, {}, nullptr, &ducts);
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    double x_m = -0.010;
    const auto sweep = [&](double to_m) {
        while (std::fabs(to_m - x_m) > 1e-9) {
            x_m += std::clamp(to_m - x_m, -0.00005, 0.00005);
            input.device.device_from_stylus = {test::kAlongX, {x_m, 0.0003, 0.0002}};
            simulation.step(input, out, events);
            input.command_count = 0;
        }
    };
    const std::uint64_t before = test::allocations();
    sweep(0.020);
    for (const auto& [tool, to_m] : {std::pair{Tool::wire, 0.055},
                                     {Tool::needle, -0.010},
                                     {Tool::dilator, 0.020},
                                     {Tool::dilator, -0.020},
                                     {Tool::drain, 0.030},
                                     {Tool::wire, -0.080}}) {
        input.add({CommandKind::tool, std::uint32_t(tool)});
        sweep(to_m);
        EXPECT_EQ(out.tool, tool);
    }
    EXPECT_EQ(out.access.drain, DrainState::in_place);
    EXPECT_EQ(test::allocations() - before, 0u);
}

// HZ-FORCE-18
TEST(Allocation, ToolsOnTheSkinAllocateNothing) {
    patient::Package package = test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.048}}, 0.001);
    package.motion = test::makeShift(-0.010);
    test::SimulationBench bench(package, {}, true);
    double felt_n = 0.0;
    int incisions = 0;

    const std::uint64_t before = test::allocations();
    for (int i = 0; i < 9000; ++i) {
        // 1.5 s with each tool, twice: 5 mm into the skin, along it, and out.
        const double share = double(i % 1500) / 1500.0;
        if (i % 1500 == 0) bench.select(Tool(i / 1500 % 3));
        if (i % 1500 == 1400) bench.command(CommandKind::park, 1);
        bench.to({0.025 * std::sin(3.14159 * share) - 0.020, 0.0, 0.010 * share});
        felt_n = std::max(felt_n, glm::length(bench.out.tool_force.force_n));
        incisions = bench.simulation.state().tools.incisions.count;
    }
    EXPECT_EQ(test::allocations() - before, 0u);
    EXPECT_GT(felt_n, 0.2);
    EXPECT_GE(incisions, 1);
}

}  // namespace
}  // namespace stylet::haptics
