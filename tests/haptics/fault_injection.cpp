#include "tests/haptics/fault_injection.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/haptics/random_column.h"
#include "tests/haptics/scripted.h"

namespace stylet::test {

namespace {

using namespace haptics;

constexpr double kZeroForceDeadline_s = 0.020, kObservation_s = 0.045;
constexpr std::array<const char*, kInjectedCount> kNames{
    "unplugged", "hand off",     "focus lost", "pose not finite",  "rotation not unit", "far away",
    "leap",      "out of reach", "silence",    "force not finite", "tissue not finite", "energy not finite"};
constexpr std::array<Fault, kInjectedCount> kBits{
    kFaultDeviceLost, kFaultHandOff,    kFaultNotFocused, kFaultBadPose,  kFaultBadPose,  kFaultBadPose,
    kFaultOverSpeed,  kFaultOutOfReach, kFaultStaleInput, kFaultBadForce, kFaultBadForce, kFaultBadForce};

double randomNonFinite(Random& random) {
    constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL};
    return kBad[random() % 3];
}
Vec3 direction(Random& random) {
    Vec3 d;
    do
        d = {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    while (glm::dot(d, d) < 0.01);
    return d / std::sqrt(glm::dot(d, d));
}

// One fault, identical in each of its ticks.
struct Injection {
    Injected what = Injected::unplugged;
    double bad = 0.0;  // value that replaces a valid number
    unsigned field = 0;
    Vec3 way{0.0};

    void into(DeviceState& device) const {
        Pose& pose = device.device_from_stylus;
        if (what == Injected::unplugged) device.flags &= ~std::uint32_t(kDeviceReady);
        if (what == Injected::handOff) device.flags &= ~std::uint32_t(kDeviceHandOn);
        if (what == Injected::poseNotFinite && field < 3) pose.position_m[int(field)] = bad;
        if (what == Injected::poseNotFinite && field >= 3) pose.rotation[int(field) - 3] = bad;
        if (what == Injected::rotationNotUnit) pose.rotation *= bad;
        if (what == Injected::silence) device.fresh = 0;
        const bool moved =
            what == Injected::farAway || what == Injected::leap || what == Injected::outOfReach;
        if (!moved) return;
        pose.position_m += way;
        device.fresh = 1;
    }
    void into(ToolForce& tool) const {
        if (what == Injected::forceNotFinite) tool.force_n[int(field % 3)] = bad;
        if (what == Injected::tissueNotFinite) tool.tissue_moved_m[int(field % 3)] = bad;
        if (what == Injected::energyNotFinite) tool.energy_j = bad;
    }
};

Injection drawn(Random& random, int kinds, const DeviceProfile& profile) {
    Injection i;
    do
        i.what = Injected(random() % std::uint64_t(kinds));
    while (i.what == Injected::outOfReach && std::isnan(profile.workspace_radius_m));
    i.bad = randomNonFinite(random);
    i.field = unsigned(random() % 7);
    double length_m = 0.0;
    if (i.what == Injected::rotationNotUnit) i.bad = random() % 2 == 0 ? 0.0 : uniform(random, 1.01, 3.0);
    if (i.what == Injected::farAway) length_m = uniform(random, 40.0, 1e6);
    if (i.what == Injected::leap) length_m = uniform(random, 0.005, 0.5);
    if (i.what == Injected::outOfReach) length_m = uniform(random, 3.0, 20.0) * profile.workspace_radius_m;
    i.way = length_m * direction(random);
    return i;
}

// Returns a duration in ticks. A silence must be long enough for the watchdog to notice it.
int duration(Random& random, Injected what, double rate_hz) {
    if (random() % 4 == 0) return std::numeric_limits<int>::max();
    const int least = what == Injected::silence ? int(std::lround(0.021 * rate_hz)) : 1;
    return least + int(random() % 30);
}

// Checks the ticks that follow an injection.
struct ZeroForceCheck {
    InjectionTotals& totals;
    Injected what;
    double dt_s, peak_n;
    int ticks = 0, last_force = 0;
    std::string why = {};

    void tick(const Vec3& sent_n) {
        ++ticks;
        if (sent_n != Vec3(0.0)) last_force = ticks;
        // NaN fails this comparison.
        if (!(glm::dot(sent_n, sent_n) <= peak_n * peak_n * (1.0 + 1e-9))) why = "a force beyond the device";
    }
    void end(std::uint32_t faults, ForceStage stage) {
        const std::size_t cause = std::size_t(what);
        ++totals.injections;
        ++totals.by_cause[cause];
        const double zero_after_s = last_force * dt_s;
        totals.slowest_s[cause] = std::max(totals.slowest_s[cause], zero_after_s);
        if (zero_after_s > kZeroForceDeadline_s + 1e-9) why = fmt::format("force after {} s", zero_after_s);
        if ((faults & kBits[cause]) == 0) why = "without its name";
        if (stage != ForceStage::off) why = "not off";
        if (why.empty()) return;
        if (totals.failures++ == 0)
            totals.first_failure = fmt::format("{}, {} Hz: {}", kNames[cause], 1.0 / dt_s, why);
    }
};

// A stylus that sways on a spring whose anchor moves with breathing. The device delivers data at 1 kHz at any
// loop rate.
struct Bench {
    DeviceProfile profile;
    double rate_hz = 1000.0, gain = 1.0;
    std::uint64_t tick = 0;
    OutputSettings settings;
    OutputState state;
    DeviceState device;
    Vec3 tissue_m{0.0};

    double dt_s() const { return 1.0 / rate_hz; }
    Vec3 step(const Injection* injection) {
        const double t_s = double(tick) / rate_hz;
        const std::uint64_t ticks_a_reading = std::uint64_t(rate_hz / 1000.0);
        device.fresh = tick++ % ticks_a_reading == 0;
        if (device.fresh != 0)
            device.device_from_stylus.position_m = {0.004 * std::sin(9.0 * t_s), 0.002 * std::sin(41.0 * t_s),
                                                    0.0};
        OutputTick now;
        const Vec3 tissue = {0.003 * std::sin(1.5 * t_s), 0.0, 0.001};
        now.tool.tissue_moved_m = tissue - tissue_m;
        tissue_m = tissue;
        const Vec3 stretched = device.device_from_stylus.position_m - tissue;
        now.tool.force_n = -1000.0 * stretched * std::min(1.0, 10.0 * std::max(0.0, t_s - 0.05));
        now.tool.energy_j = 500.0 * glm::dot(stretched, stretched);
        DeviceState read = device;
        if (injection) injection->into(read), injection->into(now.tool);
        if (injection && injection->what == Injected::focusLost) state.safety.focused = false;
        now.fault_bits = checkDevice(state.safety, profile, read, dt_s());
        now.grip_m = isPose(read.device_from_stylus) ? read.device_from_stylus.position_m : state.grip_m;
        return stepOutput(state, settings, profile, gain, now, dt_s());
    }
};

// Returns benches that have reached several times during and after their start ramp.
std::vector<Bench> makeArmedBenches() {
    DeviceProfile strong, small{.name = "small", .force_peak_n = 8.0, .source = ""}, unknown;
    small.workspace_radius_m = 0.04;
    unknown.force_peak_n = unknown.stiffness_n_per_m = kUnknown;
    std::vector<Bench> benches;
    for (const DeviceProfile& profile : {strong, small, unknown})
        for (const double rate_hz : {1000.0, 2000.0, 4000.0}) {
            Bench bench;
            bench.profile = profile;
            bench.rate_hz = rate_hz;
            bench.gain = outputGain(profile, bench.settings);
            for (const double until_s : {0.2, 0.7, 1.3, 1.7, 2.3}) {
                while (double(bench.tick) < until_s * rate_hz)
                    bench.step(nullptr);
                benches.push_back(bench);
            }
        }
    return benches;
}

}  // namespace

const char* injectedName(Injected what) {
    return kNames[std::size_t(what)];
}

double InjectionTotals::slowest() const {
    return *std::max_element(slowest_s.begin(), slowest_s.end());
}

InjectionTotals injectIntoOutput(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    const std::vector<Bench> benches = makeArmedBenches();
    InjectionTotals totals;
    for (std::uint64_t i = 0; i < count; ++i) {
        Bench bench = benches[random() % benches.size()];
        for (std::uint64_t before = random() % 8; before > 0; --before)
            bench.step(nullptr);
        const Injection injection = drawn(random, kInjectedCount, bench.profile);
        const int lasts = duration(random, injection.what, bench.rate_hz);
        ZeroForceCheck watch{totals, injection.what, bench.dt_s(),
                             valueOrDefault(bench.profile.force_peak_n, kWeakestForce_n)};
        for (int tick = 0; tick < int(kObservation_s * bench.rate_hz); ++tick)
            watch.tick(bench.step(tick < lasts ? &injection : nullptr));
        watch.end(bench.state.safety.faults, bench.state.safety.stage);
    }
    return totals;
}

InjectionTotals injectIntoSimulation(std::uint64_t count, std::uint64_t seed) {
    constexpr int kEvery = 50, kRisen = 1700, kModelFaults = 3;
    Random random(seed);
    const patient::Package package = scriptedPackage();
    const patient::Patient patient(package);
    const Trace trace = scriptedTrace();
    SimulationSettings settings;
    settings.profile.workspace_radius_m = 0.2;
    Simulation simulation(patient, settings);
    TickOutput out;
    NeedleEvents events;
    // The force rises while the device rests, before the script starts.
    const auto inputAt = [&](int tick) { return scriptedInput(trace, std::max(0, tick - kRisen)); };
    std::vector<Simulation> along;
    for (int tick = 0; tick < kRisen + kScriptedTicks - 100; ++tick) {
        if (tick >= kRisen && tick % kEvery == 0) along.push_back(simulation);
        simulation.step(inputAt(tick), out, events);
    }
    InjectionTotals totals;
    for (std::uint64_t i = 0; i < count; ++i) {
        Simulation injected = along[random() % along.size()];
        const int from = int(injected.state().tick);
        const Injection injection = drawn(random, kInjectedCount - kModelFaults, settings.profile);
        const int lasts = duration(random, injection.what, 1000.0);
        ZeroForceCheck watch{totals, injection.what, 0.001, settings.profile.force_peak_n};
        for (int tick = 0; tick < int(kObservation_s * 1000.0); ++tick) {
            TickInput input = inputAt(from + tick);
            if (tick < lasts) injection.into(input.device);
            if (tick == 0 && injection.what == Injected::focusLost)
                input.commands[input.command_count++] = {CommandKind::focus, 0};
            injected.step(input, out, events);
            watch.tick(out.sent_device_n);
        }
        watch.end(out.faults, out.stage);
    }
    return totals;
}

}  // namespace stylet::test
