// Injects over a million faults and reports the longest time from a fault to zero force.

#include <fmt/core.h>

#include "tests/bench/bench.h"
#include "tests/haptics/fault_injection.h"

namespace stylet::bench {
namespace {

void addRow(std::vector<Row>& rows, const char* where, const test::InjectionTotals& totals, double time_ms) {
    const std::string note =
        fmt::format("{}: {} injections, {} failed; {}", where, totals.injections, totals.failures,
                    totals.failures > 0 ? totals.first_failure.c_str() : "each in time and by name");
    rows.push_back({"haptics.fault_injection", "injections", double(totals.injections), time_ms,
                    1e3 * totals.slowest(), "ms to zero force", "20 ms", note});
}

void run(std::vector<Row>& rows) {
    auto began = std::chrono::steady_clock::now();
    const test::InjectionTotals stage = test::injectIntoOutput(1'000'000, 11);
    addRow(rows, "output stage", stage, elapsed_ms(began));
    began = std::chrono::steady_clock::now();
    const test::InjectionTotals whole = test::injectIntoSimulation(100'000, 12);
    addRow(rows, "whole simulation", whole, elapsed_ms(began));
}

const Registration registration("haptics.fault_injection", run);

}  // namespace
}  // namespace stylet::bench
