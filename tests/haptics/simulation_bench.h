// A patient, a simulation and its tick buffers, for tests that move the stylus tick by tick.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "haptics/loop/simulation.h"
#include "tests/haptics/along_x.h"

namespace stylet::test {

inline haptics::SimulationSettings startWith(haptics::Tool tool) {
    haptics::SimulationSettings settings;
    settings.tools.first = tool;
    return settings;
}

struct SimulationBench {
    // With `with_skin` the finger, probe and scalpel feel the patient's skin.
    explicit SimulationBench(const patient::Package& p, const haptics::SimulationSettings& settings = {},
                             bool with_skin = false)
        : package(p),
          simulation(patient, settings,
                     with_skin ? &touch.emplace(haptics::makeTouchMap(patient)) : nullptr) {
        input.device.device_from_stylus = {kAlongX, {-0.05, 0.0, 0.0}};  // outside the body
    }
    // Adds a command to the next tick.
    void command(haptics::CommandKind kind, std::uint32_t value = 0) { input.add({kind, value}); }
    void select(haptics::Tool tool) { command(haptics::CommandKind::tool, std::uint32_t(tool)); }
    // Runs ticks with the current pose.
    void tick(int count = 1) {
        for (; count > 0; --count, input.command_count = 0)
            simulation.step(input, out, events);
    }
    // Runs one tick at `tip_m`. The tool points along +x.
    void to(const Vec3& tip_m) {
        input.device.device_from_stylus = {kAlongX, tip_m};
        tick();
    }
    void to(double x_m) { to({x_m, 0.0003, 0.0002}); }
    // Moves along x in steps of at most 90 um.
    void sweep(double x_m) {
        Vec3 tip = input.device.device_from_stylus.position_m;
        while (std::fabs(x_m - tip.x) > 1e-9) {
            tip.x += std::clamp(x_m - tip.x, -0.00009, 0.00009);
            to(tip);
        }
    }

    patient::Package package;
    patient::Patient patient{package};
    std::optional<haptics::TouchMap> touch;
    haptics::Simulation simulation;
    haptics::TickInput input;
    haptics::TickOutput out;
    haptics::NeedleEvents events;
};

}  // namespace stylet::test
