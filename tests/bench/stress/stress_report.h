// The campaign's table and its JSON.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/stress/stress_run.h"

namespace stylet::stress {

struct JudgedCase {
    StressCase what;
    CaseResult result;
};

// One cell of the table: a controller setting and a kind of hand.
struct Tally {
    int cases = 0, failed = 0;
    int not_finite = 0, energy = 0, cycles = 0, steps = 0, faulted = 0, idle = 0, unjudged = 0;
    double worst_rise_j = 0.0, worst_rise_over_limit = 0.0;
    double widest_cycle_m = 0.0, slowest_hz = 0.0, fastest_hz = 0.0;
    double worst_step_n = 0.0;
    double max_bare_ratio = 0.0, max_held_ratio = 0.0;
    int active_bare = 0, active_held = 0;  // cases above section 4's bound, by physical damping
    std::uint64_t ticks = 0;
};
Tally tally(const std::vector<JudgedCase>&);
Tally tally(const std::vector<JudgedCase>&, HandKind);

void printTable(const std::vector<JudgedCase>& off, const std::vector<JudgedCase>& on,
                const std::vector<StillHand>&);
void printFailures(const std::vector<JudgedCase>&, int max_count);
// Throws std::runtime_error if the file cannot be written.
void writeJson(const std::vector<JudgedCase>& off, const std::vector<JudgedCase>& on,
               const std::vector<StillHand>&, const std::string& path);

}  // namespace stylet::stress
