#include "tests/bench/stress/stress_report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace stylet::stress {

namespace {

using Json = nlohmann::ordered_json;

const char* nameOf(HandKind hand) {
    constexpr const char* kNames[]{"none", "light", "firm"};
    return kNames[std::size_t(hand)];
}
const char* nameOf(Pattern pattern) {
    constexpr const char* kNames[]{"push", "pull back", "in steps", "trembling"};
    return kNames[std::size_t(pattern)];
}

void add(Tally& t, const CaseResult& r) {
    ++t.cases;
    t.ticks += r.ticks;
    t.failed += r.fails();
    t.not_finite += r.not_finite;
    t.energy += r.energyFails();
    t.steps += r.stepFails();
    t.faulted += r.faults != 0;
    t.idle += r.forced_share < 0.05;
    t.unjudged += !r.cycle_judged;
    t.worst_rise_j = std::max(t.worst_rise_j, r.rise_j);
    t.worst_rise_over_limit = std::max(t.worst_rise_over_limit, r.rise_j / r.rise_limit_j);
    t.worst_step_n = std::max(t.worst_step_n, r.step_n);
    t.max_bare_ratio = std::max(t.max_bare_ratio, r.bare_ratio);
    t.max_held_ratio = std::max(t.max_held_ratio, r.held_ratio);
    t.active_bare += r.bare_ratio > 1.0;
    t.active_held += r.held_ratio > 1.0;
    if (!r.cycles()) return;
    t.slowest_hz = t.cycles == 0 ? r.cycle.hz : std::min(t.slowest_hz, r.cycle.hz);
    t.fastest_hz = std::max(t.fastest_hz, r.cycle.hz);
    t.widest_cycle_m = std::max(t.widest_cycle_m, r.cycle.amplitude_m);
    ++t.cycles;
}

void printRow(const char* controller, const char* hand, const Tally& t) {
    std::printf("%-4s %-6s %6d %6d %6d %6d %9.0f %7.2f %6d %8.0f %5.0f-%-4.0f %6d %7.3f %6d\n", controller,
                hand, t.cases, t.failed, t.not_finite, t.energy, 1e6 * t.worst_rise_j,
                t.worst_rise_over_limit, t.cycles, 1e6 * t.widest_cycle_m, t.slowest_hz, t.fastest_hz,
                t.steps, t.worst_step_n, t.faulted);
}

Json toJson(const Tally& t) {
    return {{"cases", t.cases},
            {"ticks", t.ticks},
            {"failed", t.failed},
            {"not_finite", t.not_finite},
            {"energy", t.energy},
            {"worst_rise_j", t.worst_rise_j},
            {"worst_rise_over_limit", t.worst_rise_over_limit},
            {"limit_cycles", t.cycles},
            {"widest_cycle_m", t.widest_cycle_m},
            {"slowest_hz", t.slowest_hz},
            {"fastest_hz", t.fastest_hz},
            {"force_steps", t.steps},
            {"worst_step_n", t.worst_step_n},
            {"faulted", t.faulted},
            {"without_force", t.idle},
            {"cycle_not_judged", t.unjudged},
            {"worst_tangent_over_bound_bare", t.max_bare_ratio},
            {"worst_tangent_over_bound_held", t.max_held_ratio},
            {"above_bound_bare", t.active_bare},
            {"above_bound_held", t.active_held}};
}

Json toJson(const JudgedCase& j) {
    const StressCase& c = j.what;
    const CaseResult& r = j.result;
    return {{"device", c.device->name},
            {"tissues", Tissues::name(c.tissues)},
            {"hand", nameOf(c.hand)},
            {"pattern", nameOf(c.pattern)},
            {"rate_hz", c.rate_hz},
            {"delay_s", c.delay_s},
            {"jitter_s", c.jitter_s},
            {"resolution_m", c.resolution_m},
            {"mass_kg", c.mass_kg},
            {"damping_n_s_per_m", c.damping_n_s_per_m},
            {"friction_n", c.friction_n},
            {"breath_amplitude", c.breath_amplitude},
            {"depth_m", c.depth_m},
            {"speed_m_s", c.speed_m_s},
            {"tilt_rad", c.tilt_rad},
            {"seed", c.seed},
            {"rise_j", r.rise_j},
            {"rise_limit_j", r.rise_limit_j},
            {"cycle_m", r.cycle.amplitude_m},
            {"cycle_hz", r.cycle.hz},
            {"cycles", r.cycles()},
            {"step_n", r.step_n},
            {"faults", r.faults}};
}

Json toColumnJson(const std::vector<JudgedCase>& cases) {
    Json column{{"all", toJson(tally(cases))}};
    for (const HandKind hand : {HandKind::none, HandKind::light, HandKind::firm})
        column[nameOf(hand)] = toJson(tally(cases, hand));
    Json failures = Json::array();
    for (const JudgedCase& j : cases)
        if (j.result.fails()) failures.push_back(toJson(j));
    column["failures"] = failures;
    return column;
}

}  // namespace

Tally tally(const std::vector<JudgedCase>& cases) {
    Tally t;
    for (const JudgedCase& j : cases)
        add(t, j.result);
    return t;
}

Tally tally(const std::vector<JudgedCase>& cases, HandKind hand) {
    Tally t;
    for (const JudgedCase& j : cases)
        if (j.what.hand == hand) add(t, j.result);
    return t;
}

void printTable(const std::vector<JudgedCase>& off, const std::vector<JudgedCase>& on,
                const std::vector<StillHand>& still) {
    std::printf(
        "controller    cases failed    nan energy  rise[uJ] /limit cycles amp[um]        Hz  steps "
        "most[N] faulted\n");
    for (const auto& [name, cases] : {std::pair{"off", &off}, std::pair{"on", &on}}) {
        for (const HandKind hand : {HandKind::none, HandKind::light, HandKind::firm})
            printRow(name, nameOf(hand), tally(*cases, hand));
        printRow(name, "all", tally(*cases));
    }
    const Tally t = tally(on);
    std::printf(
        "worst tangent over 2b/T, b physical: bare up to %.0f, above 1 in %d of %d cases; with the hand "
        "up to %.2f, above 1 in %d\n",
        t.max_bare_ratio, t.active_bare, t.cases, t.max_held_ratio, t.active_held);
    std::printf(
        "%d of %d cases had no force at rest, %d an event in the window for limit cycles; %.3g ticks with "
        "the controller on, %.3g off\n",
        t.idle, t.cases, t.unjudged, double(t.ticks), double(tally(off).ticks));
    for (const StillHand& s : still)
        std::printf(
            "still hand, %s on %s at %d Hz: the breath is felt as %.3f N with the controller, %.3f N "
            "without; "
            "they differ by at most %.4f N%s\n",
            s.rigid ? "rigid" : "firm", s.device, s.rate_hz, s.on_n, s.off_n, s.apart_n,
            s.fails() ? "  FAILS" : "");
}

void printFailures(const std::vector<JudgedCase>& cases, int max_count) {
    for (const JudgedCase& j : cases)
        if (j.result.fails() && max_count-- > 0) std::printf("  %s\n", toJson(j).dump().c_str());
}

void writeJson(const std::vector<JudgedCase>& off, const std::vector<JudgedCase>& on,
               const std::vector<StillHand>& still, const std::string& path) {
    Json hands = Json::array();
    for (const StillHand& s : still)
        hands.push_back({{"device", s.device},
                         {"hand", s.rigid ? "rigid" : "firm"},
                         {"rate_hz", s.rate_hz},
                         {"felt_on_n", s.on_n},
                         {"felt_off_n", s.off_n},
                         {"apart_n", s.apart_n},
                         {"fails", s.fails()}});
    std::ofstream file(path);
    file << Json{{"off", toColumnJson(off)}, {"on", toColumnJson(on)}, {"still_hand", hands}}.dump(1) << '\n';
    if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace stylet::stress
