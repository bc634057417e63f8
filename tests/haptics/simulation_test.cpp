#include "haptics/loop/simulation.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "tests/haptics/scripted.h"
#include "tests/haptics/simulation_bench.h"
#include "tests/support/constants.h"
#include "tests/support/motion.h"

namespace stylet::haptics {
namespace {

using test::SimulationBench;

struct Outcome {
    std::uint64_t hash = 0, ticks = 0;
    int punctures = 0, withdrawn = 0;
    double peak_n = 0.0;
};

Outcome play(const patient::Package& package, const SimulationSettings& settings = {},
             const std::function<void(int, TickInput&)>& change = {}) {
    const Trace trace = test::scriptedTrace();
    SimulationBench bench(package, settings);
    Outcome result;
    for (int i = 0; i < test::kScriptedTicks; ++i) {
        bench.input = test::scriptedInput(trace, i);
        if (change) change(i, bench.input);
        bench.tick();
        result.peak_n = std::max(result.peak_n, bench.out.force_n);
        for (const NeedleEvent& e : bench.events.all()) {
            result.punctures += e.kind == NeedleEventKind::puncture;
            result.withdrawn += e.kind == NeedleEventKind::withdrawn;
        }
    }
    result.hash = bench.out.state_hash;
    result.ticks = bench.out.tick;
    return result;
}

// Equal on every compiler, build type and machine. Update only together with an intended change of the
// model.
constexpr std::uint64_t kExpectedTick = 6000, kExpectedHash = 0xc4baac5d34737e59ull;

TEST(Simulation, ScriptedPunctureEndsInTheExpectedHash) {
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
            if (i == 2500) input.add({kind, 0});
        });
    };
    for (const CommandKind kind :
         {CommandKind::cough, CommandKind::sigh, CommandKind::move, CommandKind::fault})
        EXPECT_EQ(with(kind).hash, with(kind).hash) << int(kind);
}

// A hand holds the needle still in tissue while the patient moves as commanded. Different tissue reaches
// the tip, and no tick changes the force by more than 0.05 N.
// HZ-FORCE-04
TEST(Simulation, InjectedEventMovesAStillNeedleWithoutAJump) {
    const Trace trace = test::scriptedTrace();
    constexpr int kInside = 2500, kWatched = 6000;
    std::vector<Vec3> calm_m;  // tip in the reference without an injected event
    for (const CommandKind kind :
         {CommandKind::marker, CommandKind::cough, CommandKind::sigh, CommandKind::move}) {
        SimulationBench bench(test::scriptedPackage());
        const TickOutput& out = bench.out;
        for (int i = 0; i < kInside; ++i) {
            bench.input = test::scriptedInput(trace, i);
            bench.tick();
        }
        ASSERT_NE(out.phase, Phase::outside);
        bench.command(kind);
        double most_n = 0.0, apart_m = 0.0;
        for (int i = 0; i < kWatched; ++i) {
            const double before_n = out.force_n;
            const Vec3 sent_before_n = out.sent_device_n;
            bench.tick();
            if (bench.events.count == 0) {
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

TEST(Simulation, BreathingScaleTakesEffectAtTheNextBreathWithoutAJump) {
    SimulationSettings settings;
    settings.breath.emplace();
    settings.breath->rhythm = {4.0, 0.8};
    constexpr double kDepth = 1.7, kRate = 1.6, kSteepest = 0.3247595264191645;  // maximum slope of sin^3 cos
    const double slope_per_s = 4.0 * 3.14159265358979 / (4.0 / kRate) * 0.8 * kDepth * kSteepest;
    // At rest, during inhale, at full inhale, during exhale, and in the middle of a sigh.
    for (const int at : {0, 1000, 2000, 3100, 5500}) {
        SimulationBench bench(test::scriptedPackage(), settings);
        const TickOutput& out = bench.out;
        double peak_v = 0.0;
        std::vector<int> rises;  // crossings of half the depth, once all commands have taken effect
        for (int i = 0; i < 24'000; ++i) {
            if (at == 5500 && i == 4500) bench.command(CommandKind::sigh);
            if (i == at) bench.input.add(breathingCommand({kDepth, kRate}));
            const TickOutput before = out;
            bench.tick();
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
    EXPECT_EQ(breathingScale(breathingCommand({1.2345, 9.0})), (BreathingScale{1.235, kMaxBreathingScale}));
    EXPECT_EQ(breathingScale(breathingCommand({std::nan(""), -1.0})),
              (BreathingScale{kMinBreathingScale, kMinBreathingScale}));
    EXPECT_EQ(breathingScale({CommandKind::breathing, 0xffffffffu}),
              (BreathingScale{kMaxBreathingScale, kMaxBreathingScale}));
}

TEST(Simulation, ARecordedBreathIsNotScaledAndAScaleIsHashed) {
    SimulationSettings settings;
    settings.breath.emplace();
    settings.breath->recording_v = {0.0, 0.4, 0.9, 0.3};
    const auto breaths = [&](std::optional<Command> command) {
        SimulationBench bench(test::scriptedPackage(), settings);
        std::vector<double> v;
        for (int i = 0; i < 1500; ++i) {
            if (command && i == 100) bench.input.add(*command);
            bench.tick();
            v.push_back(bench.out.breath.v);
        }
        return std::pair(v, bench.out.state_hash);
    };
    const auto calm = breaths(std::nullopt), scaled = breaths(breathingCommand({1.5, 1.0}));
    EXPECT_EQ(calm.first, scaled.first);
    EXPECT_NE(calm.second, scaled.second);
}

// No breath hold starts during a sigh: v is constant while the breath is reported as held.
TEST(Simulation, BreathHoldDoesNotStartDuringASigh) {
    SimulationSettings settings;
    settings.breath.emplace();  // enables breathing
    SimulationBench bench(test::scriptedPackage(), settings);
    int held = 0;
    for (int i = 0; i < 20'000; ++i) {
        if (i == 3000) bench.command(CommandKind::sigh);
        if (i == 3100) bench.command(CommandKind::holdBreath);
        bench.tick();
        if (!bench.out.breath_held) continue;
        ++held;
        ASSERT_NEAR(bench.out.breath.v, 0.0, 1e-6) << i;
        ASSERT_EQ(bench.out.breath.rate_per_s, 0.0) << i;
    }
    EXPECT_GT(held, 5000);
}

// The patient flinches and returns according to a closed form. The tool keeps its place in the room.
TEST(Simulation, StartledPatientMovesUnderTheTool) {
    SimulationBench bench(test::scriptedPackage());
    const TickOutput& out = bench.out;
    bench.tick(10);
    const Vec3 at_m = out.patient_from_tool.position_m;
    bench.command(CommandKind::move);
    double most_m = 0.0, fastest_m_s = 0.0;
    Vec3 before_m(0.0);
    for (int i = 1; i <= 2000; ++i) {
        bench.tick();
        const double t_s = 0.001 * i, s = t_s < kStartleDuration_s
                                              ? std::sin(3.14159265358979323846 * t_s / kStartleDuration_s)
                                              : 0.0;
        EXPECT_NEAR(glm::length(out.patient_moved_m - kStartleDisplacement_m * (s * s * s * s)), 0.0, 1e-12)
            << i;
        EXPECT_NEAR(glm::length(out.patient_from_tool.position_m + out.patient_moved_m - at_m), 0.0, 1e-12);
        most_m = std::max(most_m, glm::length(out.patient_moved_m));
        fastest_m_s = std::max(fastest_m_s, 1000.0 * glm::length(out.patient_moved_m - before_m));
        before_m = out.patient_moved_m;
    }
    EXPECT_NEAR(most_m, glm::length(kStartleDisplacement_m), 1e-6);
    EXPECT_LT(fastest_m_s, 0.018);
    EXPECT_EQ(out.patient_moved_m, Vec3(0.0));
}

// The instructor injects a device fault. The force is zero within 20 ms and returns only after re-arming.
// HZ-FORCE-08
TEST(Simulation, InjectedFaultRemovesTheForceUntilRearmed) {
    SimulationBench bench(test::scriptedPackage());
    bench.tick(2000);
    ASSERT_EQ(bench.out.stage, ForceStage::on);
    bench.command(CommandKind::fault);
    bench.tick(20);
    EXPECT_EQ(bench.out.stage, ForceStage::off);
    EXPECT_EQ(bench.out.level, 0.0);
    EXPECT_EQ(bench.out.faults, kFaultInjected);
    bench.command(CommandKind::rearm);
    bench.tick(2000);
    EXPECT_EQ(bench.out.stage, ForceStage::on);
    EXPECT_EQ(bench.out.faults, 0u);
}

// The state is complete: a copy continues identically, including pending breathing commands.
TEST(Simulation, ContinuesFromACopyWithTheSameHash) {
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
TEST(Simulation, EveryInputBitChangesTheHash) {
    const patient::Package package = test::scriptedPackage();
    const std::uint64_t hash = play(package).hash;
    EXPECT_EQ(play(package).hash, hash);

    const auto flip = [](double& v) { v = std::bit_cast<double>(std::bit_cast<std::uint64_t>(v) ^ 1u); };
    const std::function<void(TickInput&)> inputs[] = {
        [&](TickInput& in) { flip(in.device.device_from_stylus.position_m.x); },
        [](TickInput& in) { in.device.buttons = 1; },
        [](TickInput& in) { in.device.flags = kDeviceReady; },
        [](TickInput& in) { in.add({CommandKind::marker, 3}); },
    };
    for (const auto& change : inputs)
        EXPECT_NE(play(package, {},
                       [&](int i, TickInput& in) {
                           if (i == 777) change(in);
                       })
                      .hash,
                  hash);
    const std::function<void(SimulationSettings&)> settings[] = {
        [](SimulationSettings& s) { s.seed = 1; },
        [](SimulationSettings& s) { s.scenario_digest = 1; },
        [](SimulationSettings& s) { s.tools.first = Tool::guide; },
        [&](SimulationSettings& s) { flip(s.tools.guide.release_n); },
        [&](SimulationSettings& s) { flip(s.tools.needle.a1_share); },
    };
    for (const auto& change : settings) {
        SimulationSettings changed;
        change(changed);
        EXPECT_NE(play(package, changed).hash, hash);
    }

    patient::Package other = package;
    flip(other.tissues[std::size_t(Tissue::vessel)].friction_n);  // tissue not on the path
    EXPECT_NE(play(other).hash, hash);
    other = package;
    other.ct.voxels[5] += 1;
    EXPECT_NE(play(other).hash, hash);
}

// Rests with the tip at `x_m` until the force has risen.
void rise(SimulationBench& bench, double x_m) {
    const Pose device_from_patient = bench.simulation.settings().patient_from_device.inverse();
    bench.input.device.device_from_stylus = device_from_patient * Pose{test::kAlongX, {x_m, 0.0, 0.0}};
    bench.tick(1600);
    EXPECT_EQ(bench.out.stage, ForceStage::on);
}

// HZ-FORCE-03
TEST(Simulation, ImpossiblePoseNeverReachesTheModel) {
    const double nan = test::kNaN;
    const Pose bad[] = {{test::kAlongX, {nan, 0.0, 0.0}},  {test::kAlongX, {0.0, HUGE_VAL, 0.0}},
                        {test::kAlongX, {0.0, 0.0, 11.0}}, {{nan, 0.0, 0.0, 0.0}, Vec3(0.0)},
                        {{0.0, 0.0, 0.0, 0.0}, Vec3(0.0)}, {{1.1, 0.0, 0.0, 0.0}, Vec3(0.0)}};
    for (const Pose& pose : bad) {
        SimulationBench bench(test::scriptedPackage());
        const TickOutput& out = bench.out;
        bench.input.device.device_from_stylus = pose;
        bench.tick();  // before the first valid pose
        EXPECT_EQ(out.awaited, kFaultBadPose);
        EXPECT_FALSE(bench.simulation.state().tools.needle.primed);

        rise(bench, -0.001);
        for (int i = 0; i < 8; ++i) {
            bench.input.device.device_from_stylus.position_m.x += 0.0002;
            bench.tick();
        }
        const double last_n = out.force_n;
        EXPECT_GT(last_n, 0.0);
        EXPECT_LT(out.sent_device_n.x, 0.0);
        bench.input.device.device_from_stylus = pose;
        bench.tick(15);
        EXPECT_NEAR(out.force_n, last_n, 1e-6);  // the model keeps the last valid pose
        EXPECT_EQ(out.sent_device_n, Vec3(0.0));
        EXPECT_EQ(out.faults, kFaultBadPose);
    }
}

// HZ-FORCE-12
TEST(Simulation, FocusAndRearmAreCommands) {
    SimulationBench bench(test::scriptedPackage());
    rise(bench, -0.001);
    bench.command(CommandKind::focus, 0);
    bench.tick(20);
    EXPECT_EQ(bench.out.faults, kFaultNotFocused);
    EXPECT_EQ(bench.out.level, 0.0);
    bench.command(CommandKind::focus, 1);
    bench.tick(2000);
    EXPECT_EQ(bench.out.stage, ForceStage::off);
    bench.command(CommandKind::rearm);
    bench.tick(2000);
    EXPECT_EQ(bench.out.stage, ForceStage::on);
    EXPECT_EQ(bench.out.faults, 0u);
}

// HZ-FORCE-10
TEST(Simulation, ForcesReachTheDeviceInItsOwnFrame) {
    SimulationSettings settings;
    settings.patient_from_device = {{0.70710678118654752, 0.0, 0.0, 0.70710678118654752}, {0.0, 0.01, 0.0}};
    SimulationBench bench(test::makeColumn({{Tissue::liver, 0.05}}), settings);
    const TickOutput& out = bench.out;
    const Pose device_from_patient = settings.patient_from_device.inverse();
    rise(bench, -0.005);
    for (int i = 0; i < 200; ++i) {
        bench.input.device.device_from_stylus =
            device_from_patient * Pose{test::kAlongX, {-0.005 + 0.0001 * i, 0.0, 0.0}};
        bench.tick();
    }
    EXPECT_NEAR(out.force_n, 0.9, 1e-9);
    // Patient -x is device +y after a quarter turn about z.
    EXPECT_NEAR(out.sent_device_n.y, bench.simulation.gain() * 0.9, 1e-9);
    EXPECT_NEAR(out.sent_device_n.x, 0.0, 1e-9);
    EXPECT_NEAR(out.patient_from_needle.position_m.x, 0.0149, 1e-12);
}

TEST(Simulation, BreathHoldStartsAtEndExhale) {
    SimulationBench bench(test::scriptedPackage());
    bench.tick(1000);
    bench.command(CommandKind::holdBreath);
    bench.tick();
    EXPECT_FALSE(bench.out.breath_held);
    int waited = 0;
    for (; !bench.out.breath_held && waited < 5000; ++waited)
        bench.tick();
    EXPECT_NEAR(waited, 3000, 2);
    EXPECT_EQ(bench.out.breath.v, 0.0);
}

}  // namespace
}  // namespace stylet::haptics
