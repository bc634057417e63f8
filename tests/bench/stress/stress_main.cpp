// The stability campaign: stylet-stress [--cases N | --ticks N] [--off-every K] [--seconds S] [--seed N]
// [--threads N] [--out FILE.json]. The campaign fails in four situations:
// - A case fails with the controller on.
// - No case fails with the controller off. The campaign would then prove nothing.
// - More than a quarter of the cases has no force.
// - A still hand does not feel the breathing.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>

#include "base/parallel.h"
#include "tests/bench/stress/stress_report.h"

namespace stylet::stress {
namespace {

struct Options {
    int cases = 2000, off_every = 10, threads = 1;
    double ticks = 0.0, seconds = kCase_s;
    std::uint64_t seed = 1;
    std::string out;
};

Options parse(int argc, char** argv) {
    Options o;
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string_view name = argv[i];
        const char* const value = argv[i + 1];
        if (name == "--cases")
            o.cases = std::atoi(value);
        else if (name == "--ticks")
            o.ticks = std::atof(value);
        else if (name == "--off-every")
            o.off_every = std::atoi(value);
        else if (name == "--seconds")
            o.seconds = std::atof(value);
        else if (name == "--seed")
            o.seed = std::strtoull(value, nullptr, 10);
        else if (name == "--threads")
            o.threads = std::atoi(value);
        else if (name == "--out")
            o.out = value;
        else
            throw std::runtime_error("no option " + std::string(name));
    }
    if (o.ticks > 0.0) o.cases = int(o.ticks / (kMeanRate_hz * o.seconds)) + 1;
    if (argc % 2 == 0 || o.cases < 1 || o.off_every < 1 || o.threads < 1 ||
        !(o.seconds > kRest_s + kCycleWindow_s))
        throw std::runtime_error("an option is incomplete or out of range");
    return o;
}

std::vector<JudgedCase> judge(const Tissues& tissues, const std::vector<StressCase>& cases, bool controller,
                              const Options& o) {
    std::vector<JudgedCase> judged;
    for (const StressCase& c : cases)
        judged.push_back({c, {}});
    parallelFor(o.threads, cases.size(),
                [&](std::size_t i) { judged[i].result = runCase(cases[i], tissues, controller, o.seconds); });
    return judged;
}

int run(const Options& o) {
    const auto began = std::chrono::steady_clock::now();
    const Tissues tissues;
    const std::vector<StressCase> cases = latinHypercube(o.cases, o.seed);
    std::vector<StressCase> some;
    for (std::size_t i = 0; i < cases.size(); i += std::size_t(o.off_every))
        some.push_back(cases[i]);
    const std::vector<JudgedCase> on = judge(tissues, cases, true, o), off = judge(tissues, some, false, o);
    const std::vector<StillHand> still = stillHands(tissues);
    printTable(off, on, still);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    std::printf("%.1f s on %d thread(s)\n", seconds, o.threads);
    if (!o.out.empty()) writeJson(off, on, still, o.out);

    const Tally all = tally(on);
    const bool felt = std::none_of(still.begin(), still.end(), [](const StillHand& s) { return s.fails(); });
    if (all.failed > 0) {
        std::printf("failures with the controller on:\n");
        printFailures(on, 20);
    }
    if (tally(off).failed == 0)
        std::printf("nothing fails with the controller off: the campaign shows nothing\n");
    if (4 * all.idle > all.cases)
        std::printf("more than a quarter of the cases has no force: the campaign shows little\n");
    return all.failed == 0 && tally(off).failed > 0 && 4 * all.idle <= all.cases && felt ? 0 : 1;
}

}  // namespace
}  // namespace stylet::stress

int main(int argc, char** argv) {
    try {
        return stylet::stress::run(stylet::stress::parse(argc, argv));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-stress: %s\n", e.what());
        return 2;
    }
}
