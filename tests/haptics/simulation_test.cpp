#include "haptics/loop/simulation.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <vector>

#include "tests/haptics/scripted.h"
#include "tests/support/motion.h"

namespace stylet::haptics {
namespace {

struct Outcome {
    std::uint64_t hash = 0, ticks = 0;
    int punctures = 0, withdrawn = 0;
    double peak_n = 0.0;
};

Outcome play(const patient::Package& package, const SimulationSettings& settings = {},
             const std::function<void(int, TickInput&)>& change = {}) {
    const patient::Patient patient(package);
    const Trace trace = test::scriptedTrace();
    Simulation simulation(patient, settings);
    Outcome result;
    TickOutput out;
    NeedleEvents events;
    for (int i = 0; i < test::kScriptedTicks; ++i) {
        TickInput input = test::scriptedInput(trace, i);
        if (change) change(i, input);
        simulation.step(input, out, events);
        result.peak_n = std::max(result.peak_n, out.force_n);
        for (int e = 0; e < events.count; ++e) {
            result.punctures += events.list[std::size_t(e)].kind == NeedleEventKind::puncture;
            result.withdrawn += events.list[std::size_t(e)].kind == NeedleEventKind::withdrawn;
        }
    }
    result.hash = out.state_hash;
    result.ticks = out.tick;
    return result;
}

// Equal on every compiler, build type and machine. Update only together with an intended change of the
// model.
constexpr std::uint64_t kExpectedTick = 6000, kExpectedHash = 0x0cb3aa835165546bull;

TEST(Simulation, TheScriptEndsInItsHash) {
    const Outcome result = play(test::scriptedPackage());
    EXPECT_EQ(result.punctures, 3);  // skin, fascia, duct
    EXPECT_EQ(result.withdrawn, 1);
    EXPECT_NEAR(result.peak_n, 2.5, 0.02);
    EXPECT_EQ(result.ticks, kExpectedTick);
    EXPECT_EQ(result.hash, kExpectedHash);
    if (result.hash != kExpectedHash) {
        std::printf("new pair: tick %llu, hash 0x%016llxull\n", static_cast<unsigned long long>(result.ticks),
                    static_cast<unsigned long long>(result.hash));
    }
}

// Events injected by the instructor are deterministic.
TEST(Simulation, InjectedEventsAreDeterministic) {
    const patient::Package package = test::scriptedPackage();
    const auto with = [&](CommandKind kind) {
        return play(package, {}, [kind](int i, TickInput& input) {
            if (i == 2500) input.commands[input.command_count++] = {kind, 0};
        });
    };
    for (const CommandKind kind :
         {CommandKind::cough, CommandKind::sigh, CommandKind::move, CommandKind::fault})
        EXPECT_EQ(with(kind).hash, with(kind).hash) << int(kind);
}

// A hand holds the needle still in tissue while the patient moves as commanded. Different tissue reaches
// the tip, and no tick changes the force by more than 0.05 N.
// HZ-FORCE-04
TEST(Simulation, AnInjectedEventMovesAHeldNeedleWithoutAJump) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    const Trace trace = test::scriptedTrace();
    constexpr int kInside = 2500, kWatched = 6000;
    std::vector<Vec3> calm_m;  // tip in the reference without an injected event
    for (const CommandKind kind :
         {CommandKind::marker, CommandKind::cough, CommandKind::sigh, CommandKind::move}) {
        Simulation simulation(patient, {});
        TickOutput out;
        NeedleEvents events;
        TickInput input;
        for (int i = 0; i < kInside; ++i)
            simulation.step(input = test::scriptedInput(trace, i), out, events);
        ASSERT_NE(out.phase, Phase::outside);
        input.command_count = 1;
        input.commands[0] = {kind, 0};
        double most_n = 0.0, apart_m = 0.0;
        for (int i = 0; i < kWatched; ++i, input.command_count = 0) {
            const double before_n = out.force_n;
            const Vec3 sent_before_n = out.sent_device_n;
            simulation.step(input, out, events);
            if (events.count == 0) {
                most_n = std::max({most_n, std::fabs(out.force_n - before_n),
                                   glm::length(out.sent_device_n - sent_before_n)});
            }
            if (kind == CommandKind::marker) calm_m.push_back(out.tip_reference_m);
            apart_m = std::max(apart_m, glm::length(out.tip_reference_m - calm_m[std::size_t(i)]));
        }
        RecordProperty("kind_" + std::to_string(int(kind)) + "_mN", int(1e3 * most_n));
        EXPECT_LT(most_n, 0.05) << int(kind);
        EXPECT_EQ(apart_m > 1e-3, kind != CommandKind::marker) << int(kind) << ": " << apart_m;
        EXPECT_EQ(out.faults, 0u) << int(kind);
    }
}

TEST(Simulation, TheBreathIsScaledFromTheNextOneOnWithoutAJump) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    SimulationSettings settings;
    settings.breath.emplace();
    settings.breath->rhythm = {4.0, 0.8};
    constexpr double kDepth = 1.7, kRate = 1.6, kSteepest = 0.3247595264191645;  // maximum slope of sin^3 cos
    const double slope_per_s = 4.0 * 3.14159265358979 / (4.0 / kRate) * 0.8 * kDepth * kSteepest;
    // At rest, during inhale, at full inhale, during exhale, and in the middle of a sigh.
    for (const int at : {0, 1000, 2000, 3100, 5500}) {
        Simulation simulation(patient, settings);
        TickOutput out, before;
        NeedleEvents events;
        TickInput input;
        input.device.device_from_stylus.position_m = {-0.05, 0.0, 0.0};
        double peak_v = 0.0;
        std::vector<int> rises;  // crossings of half the depth, once all commands have taken effect
        for (int i = 0; i < 24'000; ++i) {
            input.command_count = 0;
            if (at == 5500 && i == 4500) input.commands[input.command_count++] = {CommandKind::sigh, 0};
            if (i == at) input.commands[input.command_count++] = breathingCommand({kDepth, kRate});
            before = out;
            simulation.step(input, out, events);
            if (i == 0) continue;
            // A sigh's slope adds to that of normal breathing.
            const double allowed = at == 5500 ? 2.0 * slope_per_s : slope_per_s;
            ASSERT_LE(std::fabs(out.breath.v - before.breath.v), allowed * 0.001 * 1.001) << at << ' ' << i;
            ASSERT_NEAR(out.breath.v - before.breath.v,
                        0.5 * (out.breath.rate_per_s + before.breath.rate_per_s) * 0.001, 2e-5)
                << at << ' ' << i << ": its rate is that of v";
            if (i < 14'000) continue;
            peak_v = std::max(peak_v, out.breath.v);
            const double half_v = 0.4 * kDepth;
            if (before.breath.v < half_v && out.breath.v >= half_v) rises.push_back(i);
        }
        EXPECT_NEAR(peak_v, 0.8 * kDepth, 1e-5);
        ASSERT_GE(rises.size(), 3u);
        EXPECT_EQ(rises[2] - rises[1], int(4000 / kRate));
    }
    EXPECT_EQ(breathingScale(breathingCommand({1.2345, 9.0})), (BreathingScale{1.235, kMostBreathing}));
    EXPECT_EQ(breathingScale(breathingCommand({std::nan(""), -1.0})),
              (BreathingScale{kLeastBreathing, kLeastBreathing}));
    EXPECT_EQ(breathingScale({CommandKind::breathing, 0xffffffffu}),
              (BreathingScale{kMostBreathing, kMostBreathing}));
}

TEST(Simulation, ARecordedBreathIsNotScaledAndAScaleIsHashed) {
    const patient::Package package = test::scriptedPackage();
    SimulationSettings settings;
    settings.breath.emplace();
    settings.breath->recording_v = {0.0, 0.4, 0.9, 0.3};
    const auto breaths = [&](std::optional<Command> command) {
        const patient::Patient patient(package);
        Simulation simulation(patient, settings);
        std::vector<double> v;
        TickOutput out;
        NeedleEvents events;
        for (int i = 0; i < 1500; ++i) {
            TickInput input;
            if (command && i == 100) input.commands[input.command_count++] = *command;
            simulation.step(input, out, events);
            v.push_back(out.breath.v);
        }
        return std::pair(v, out.state_hash);
    };
    const auto calm = breaths(std::nullopt), scaled = breaths(breathingCommand({1.5, 1.0}));
    EXPECT_EQ(calm.first, scaled.first);
    EXPECT_NE(calm.second, scaled.second);
}

// No breath hold starts during a sigh: v is constant while the breath is reported as held.
TEST(Simulation, NoHoldBeginsInASigh) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    SimulationSettings settings;
    settings.breath.emplace();  // enables breathing
    Simulation simulation(patient, settings);
    TickOutput out;
    NeedleEvents events;
    TickInput input;
    input.device.device_from_stylus.position_m = {-0.05, 0.0, 0.0};
    int held = 0;
    for (int i = 0; i < 20'000; ++i) {
        input.command_count = 0;
        if (i == 3000) input.commands[input.command_count++] = {CommandKind::sigh, 0};
        if (i == 3100) input.commands[input.command_count++] = {CommandKind::holdBreath, 0};
        simulation.step(input, out, events);
        if (!out.breath_held) continue;
        ++held;
        ASSERT_NEAR(out.breath.v, 0.0, 1e-6) << i;
        ASSERT_EQ(out.breath.rate_per_s, 0.0) << i;
    }
    EXPECT_GT(held, 5000);
}

// The patient flinches and returns according to a closed form. The tool keeps its place in the room.
TEST(Simulation, APatientWhoStartsMovesUnderTheTool) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    Simulation simulation(patient, {});
    TickOutput out;
    NeedleEvents events;
    TickInput input;  // outside the body
    input.device.device_from_stylus.position_m = {-0.05, 0.0, 0.0};
    for (int i = 0; i < 10; ++i)
        simulation.step(input, out, events);
    const Vec3 at_m = out.patient_from_tool.position_m;
    input.commands[0] = {CommandKind::move, 0};
    input.command_count = 1;
    double most_m = 0.0, fastest_m_s = 0.0;
    Vec3 before_m(0.0);
    for (int i = 1; i <= 2000; ++i) {
        simulation.step(input, out, events);
        input.command_count = 0;
        const double t_s = 0.001 * i,
                     s = t_s < kMove_s ? std::sin(3.14159265358979323846 * t_s / kMove_s) : 0.0;
        EXPECT_NEAR(glm::length(out.patient_moved_m - kMoved_m * (s * s * s * s)), 0.0, 1e-12) << i;
        EXPECT_NEAR(glm::length(out.patient_from_tool.position_m + out.patient_moved_m - at_m), 0.0, 1e-12);
        most_m = std::max(most_m, glm::length(out.patient_moved_m));
        fastest_m_s = std::max(fastest_m_s, 1000.0 * glm::length(out.patient_moved_m - before_m));
        before_m = out.patient_moved_m;
    }
    EXPECT_NEAR(most_m, glm::length(kMoved_m), 1e-6);
    EXPECT_LT(fastest_m_s, 0.018);
    EXPECT_EQ(out.patient_moved_m, Vec3(0.0));
}

// The instructor injects a device fault. The force is zero within 20 ms and returns only after re-arming.
// HZ-FORCE-08
TEST(Simulation, AnInjectedFaultTakesTheForceUntilRearmed) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    Simulation simulation(patient, {});
    TickOutput out;
    NeedleEvents events;
    TickInput input;
    input.device.device_from_stylus.position_m = {-0.05, 0.0, 0.0};
    const auto command = [&](CommandKind kind, int ticks) {
        input.commands[0] = {kind, 0};
        input.command_count = 1;
        for (int i = 0; i < ticks; ++i, input.command_count = 0)
            simulation.step(input, out, events);
    };
    command(CommandKind::marker, 2000);
    ASSERT_EQ(out.stage, ForceStage::on);
    command(CommandKind::fault, 20);
    EXPECT_EQ(out.stage, ForceStage::off);
    EXPECT_EQ(out.level, 0.0);
    EXPECT_EQ(out.faults, kFaultInjected);
    command(CommandKind::rearm, 2000);
    EXPECT_EQ(out.stage, ForceStage::on);
    EXPECT_EQ(out.faults, 0u);
}

// The state is complete: a copy continues identically, including pending breathing commands.
TEST(Simulation, GoesOnFromAnyCopy) {
    patient::Package package = test::scriptedPackage();
    package.motion = test::makeBending();
    const patient::Patient patient(package);
    const Trace trace = test::scriptedTrace();
    TickOutput out;
    NeedleEvents events;
    for (const int from : {700, 1777, 2345, 4001}) {
        Simulation first(patient, {});
        for (int i = 0; i < from; ++i)
            first.step(test::scriptedInput(trace, i), out, events);
        Simulation copy = first;
        for (int i = 0; i < 500; ++i)  // diverges
            first.step(test::scriptedInput(trace, from - i), out, events);
        for (int i = from; i < test::kScriptedTicks; ++i)
            copy.step(test::scriptedInput(trace, i), out, events);
        EXPECT_EQ(out.state_hash, play(package).hash) << from;
    }
}

// HZ-TEACH-13
TEST(Simulation, EveryBitOfTheFoldCounts) {
    const patient::Package package = test::scriptedPackage();
    const std::uint64_t hash = play(package).hash;
    EXPECT_EQ(play(package).hash, hash);

    const auto flipped = [](double v) { return std::bit_cast<double>(std::bit_cast<std::uint64_t>(v) ^ 1u); };
    EXPECT_NE(play(package, {},
                   [&](int i, TickInput& in) {
                       if (i == 777)
                           in.device.device_from_stylus.position_m.x =
                               flipped(in.device.device_from_stylus.position_m.x);
                   })
                  .hash,
              hash);
    EXPECT_NE(play(package, {},
                   [&](int i, TickInput& in) {
                       if (i == 777) in.device.buttons = 1;
                   })
                  .hash,
              hash);
    EXPECT_NE(play(package, {},
                   [&](int i, TickInput& in) {
                       if (i == 777) in.device.flags = kDeviceReady;
                   })
                  .hash,
              hash);
    EXPECT_NE(play(package, {},
                   [&](int i, TickInput& in) {
                       if (i == 777) in.commands[in.command_count++] = {CommandKind::marker, 3};
                   })
                  .hash,
              hash);

    SimulationSettings settings;
    settings.seed = 1;
    EXPECT_NE(play(package, settings).hash, hash);
    settings = {};
    settings.scenario_digest = 1;
    EXPECT_NE(play(package, settings).hash, hash);
    settings = {};
    settings.tools.first = Tool::guide;
    EXPECT_NE(play(package, settings).hash, hash);
    settings = {};
    settings.tools.guide.release_n = flipped(settings.tools.guide.release_n);
    EXPECT_NE(play(package, settings).hash, hash);
    settings = {};
    settings.tools.needle.a1_share = flipped(settings.tools.needle.a1_share);
    EXPECT_NE(play(package, settings).hash, hash);

    patient::Package other = package;
    other.tissues[std::size_t(Tissue::vessel)].friction_n = flipped(0.75);  // tissue not on the path
    EXPECT_NE(play(other).hash, hash);
    other = package;
    other.ct.voxels[5] += 1;
    EXPECT_NE(play(other).hash, hash);
}

// Rests with the tip at `x_m` until the force has risen.
void rise(Simulation& simulation, TickInput& input, double x_m) {
    TickOutput out;
    NeedleEvents events;
    const Pose device_from_patient = simulation.settings().patient_from_device.inverse();
    input.device.device_from_stylus = device_from_patient * Pose{test::kAlongX, {x_m, 0.0, 0.0}};
    for (int i = 0; i < 1600; ++i)
        simulation.step(input, out, events);
    EXPECT_EQ(out.stage, ForceStage::on);
}

// HZ-FORCE-03
TEST(Simulation, APoseThatCannotBeNeverReachesTheModel) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Pose bad[] = {{test::kAlongX, {nan, 0.0, 0.0}},  {test::kAlongX, {0.0, HUGE_VAL, 0.0}},
                        {test::kAlongX, {0.0, 0.0, 11.0}}, {{nan, 0.0, 0.0, 0.0}, Vec3(0.0)},
                        {{0.0, 0.0, 0.0, 0.0}, Vec3(0.0)}, {{1.1, 0.0, 0.0, 0.0}, Vec3(0.0)}};
    for (const Pose& pose : bad) {
        Simulation simulation(patient, {});
        TickInput input;
        TickOutput out;
        NeedleEvents events;
        input.device.device_from_stylus = pose;
        simulation.step(input, out, events);  // before the first valid pose
        EXPECT_EQ(out.awaited, kFaultBadPose);
        EXPECT_FALSE(simulation.state().tools.needle.primed);

        rise(simulation, input, -0.001);
        for (int i = 0; i < 8; ++i) {
            input.device.device_from_stylus.position_m.x += 0.0002;
            simulation.step(input, out, events);
        }
        const double last_n = out.force_n;
        EXPECT_GT(last_n, 0.0);
        EXPECT_LT(out.sent_device_n.x, 0.0);
        input.device.device_from_stylus = pose;
        for (int i = 0; i < 15; ++i)
            simulation.step(input, out, events);
        EXPECT_NEAR(out.force_n, last_n, 1e-6);  // the model keeps the last valid pose
        EXPECT_EQ(out.sent_device_n, Vec3(0.0));
        EXPECT_EQ(out.faults, kFaultBadPose);
    }
}

// HZ-FORCE-12
TEST(Simulation, FocusAndRearmAreCommands) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    Simulation simulation(patient, {});
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    rise(simulation, input, -0.001);
    const auto command = [&](Command c, int ticks) {
        input.command_count = 1;
        input.commands[0] = c;
        simulation.step(input, out, events);
        input.command_count = 0;
        for (int i = 1; i < ticks; ++i)
            simulation.step(input, out, events);
    };
    command({CommandKind::focus, 0}, 20);
    EXPECT_EQ(out.faults, kFaultNotFocused);
    EXPECT_EQ(out.level, 0.0);
    command({CommandKind::focus, 1}, 2000);
    EXPECT_EQ(out.stage, ForceStage::off);
    command({CommandKind::rearm, 0}, 2000);
    EXPECT_EQ(out.stage, ForceStage::on);
    EXPECT_EQ(out.faults, 0u);
}

// HZ-FORCE-10
TEST(Simulation, ForcesReachTheDeviceInItsOwnFrame) {
    const patient::Package package = test::makeColumn({{Tissue::liver, 0.05}});
    const patient::Patient patient(package);
    SimulationSettings settings;
    settings.patient_from_device = {{0.70710678118654752, 0.0, 0.0, 0.70710678118654752}, {0.0, 0.01, 0.0}};
    Simulation simulation(patient, settings);
    const Pose device_from_patient = settings.patient_from_device.inverse();
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    rise(simulation, input, -0.005);
    for (int i = 0; i < 200; ++i) {
        input.device.device_from_stylus =
            device_from_patient * Pose{test::kAlongX, {-0.005 + 0.0001 * i, 0.0, 0.0}};
        simulation.step(input, out, events);
    }
    EXPECT_NEAR(out.force_n, 0.9, 1e-9);
    // Patient -x is device +y after a quarter turn about z.
    EXPECT_NEAR(out.sent_device_n.y, simulation.gain() * 0.9, 1e-9);
    EXPECT_NEAR(out.sent_device_n.x, 0.0, 1e-9);
    EXPECT_NEAR(out.patient_from_needle.position_m.x, 0.0149, 1e-12);
}

TEST(Simulation, AHoldIsTakenAtEndExhale) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    Simulation simulation(patient, {});
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    for (int i = 0; i < 1000; ++i)
        simulation.step(input, out, events);
    input.command_count = 1;
    input.commands[0] = {CommandKind::holdBreath, 0};
    simulation.step(input, out, events);
    input.command_count = 0;
    EXPECT_FALSE(out.breath_held);
    int waited = 0;
    while (!out.breath_held && waited < 5000)
        simulation.step(input, out, events), ++waited;
    EXPECT_NEAR(waited, 3000, 2);
    EXPECT_EQ(out.breath.v, 0.0);
}

}  // namespace
}  // namespace stylet::haptics
