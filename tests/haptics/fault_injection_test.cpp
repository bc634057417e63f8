// Every injected fault must end in zero force within 20 ms and name its cause. The bench
// haptics.fault_injection runs a million of them.
#include "tests/haptics/fault_injection.h"

#include <gtest/gtest.h>

namespace stylet::test {
namespace {

void expectAllStopped(const InjectionTotals& totals, std::uint64_t count, int kinds) {
    EXPECT_EQ(totals.injections, count);
    EXPECT_EQ(totals.failures, 0u) << totals.first_failure;
    EXPECT_LE(totals.slowest(), 0.020 + 1e-9);
    for (int kind = 0; kind < kinds; ++kind) {
        EXPECT_GT(totals.by_cause[std::size_t(kind)], count / 100) << injectedName(Injected(kind));
        // For each kind of fault the force was not zero before: it took more than 10 ms to fall.
        EXPECT_GT(totals.slowest_s[std::size_t(kind)], 0.010) << injectedName(Injected(kind));
    }
}

// HZ-FORCE-07
TEST(FaultInjection, EveryFaultOfTheOutputStageEndsInZeroForce) {
    expectAllStopped(injectIntoOutput(60000, 1), 60000, kInjectedCount);
}

// HZ-FORCE-07
TEST(FaultInjection, EveryFaultAlongAPunctureEndsInZeroForce) {
    expectAllStopped(injectIntoSimulation(6000, 2), 6000, kInjectedCount - 3);
}

}  // namespace
}  // namespace stylet::test
