#include "app/trainer/view/monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace stylet::trainer {
namespace {

patient::Surrogate breathAt(double t_s, double per_minute) {
    patient::Surrogate breath;
    breath.v = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * t_s * per_minute / 60.0);
    return breath;
}

std::size_t bright(const BreathMonitor& monitor, int x0, int x1) {
    std::size_t count = 0;
    for (int y = 0; y < BreathMonitor::kHeight; ++y)
        for (int x = x0; x < x1; ++x)
            count +=
                monitor.rgba()[(std::size_t(y) * BreathMonitor::kWidth + std::size_t(x)) * 4] > 150 ? 1u : 0u;
    return count;
}

TEST(BreathMonitor, DrawsTenTimesASecondAndOnlyThen) {
    BreathMonitor monitor;
    EXPECT_EQ(monitor.revision(), 0u);
    for (int i = 0; i < 1000; ++i)
        monitor.update(i * 0.001, breathAt(i * 0.001, 15.0), false);
    EXPECT_EQ(monitor.revision(), 10u);
    EXPECT_EQ(monitor.rgba().size(), std::size_t(BreathMonitor::kWidth) * BreathMonitor::kHeight * 4);
}

TEST(BreathMonitor, TheTraceFillsTheWindowAndTheNumberIsTheRate) {
    BreathMonitor slow, fast;
    double t_s = 0.0;
    for (; t_s < 4.0; t_s += 0.05)
        slow.update(t_s, breathAt(t_s, 12.0), false);
    const std::size_t quarter = bright(slow, 0, 280);
    for (; t_s < 30.0; t_s += 0.05)
        slow.update(t_s, breathAt(t_s, 12.0), false), fast.update(t_s, breathAt(t_s, 12.0), false);
    EXPECT_GT(bright(slow, 0, 280), 2 * quarter);
    EXPECT_EQ(slow.rgba(), fast.rgba()) << "only the last seconds count";
    const auto before = slow.rgba();
    slow.update(t_s, breathAt(t_s, 12.0), true);
    EXPECT_NE(slow.rgba(), before) << "a hold is told";
}

TEST(BreathMonitor, ShowsPainOnlyIfThereIsAny) {
    BreathMonitor calm, hurt;
    calm.update(0.0, breathAt(0.0, 12.0), false);
    hurt.update(0.0, breathAt(0.0, 12.0), false, 0.3);
    EXPECT_EQ(calm.rgba(), hurt.rgba());
    hurt.update(0.2, breathAt(0.2, 12.0), false, 6.0);
    calm.update(0.2, breathAt(0.2, 12.0), false);
    EXPECT_GT(bright(hurt, 290, BreathMonitor::kWidth), bright(calm, 290, BreathMonitor::kWidth));
}

TEST(BreathMonitor, LateCaptureLeavesTheTraceUnchanged) {
    BreathMonitor monitor;
    for (double t_s = 0.0; t_s < 10.0; t_s += 0.1)
        monitor.update(t_s, breathAt(t_s, 12.0), false);
    const auto before = monitor.rgba();
    monitor.update(9.5, breathAt(9.5, 12.0), true);
    EXPECT_EQ(monitor.rgba(), before);
}

TEST(BreathMonitor, ClearsWhenTimeGoesBack) {
    BreathMonitor monitor;
    for (double t_s = 100.0; t_s < 110.0; t_s += 0.1)
        monitor.update(t_s, breathAt(t_s, 12.0), false);
    const std::size_t full = bright(monitor, 0, 280);
    monitor.update(1.0, breathAt(1.0, 12.0), false);
    EXPECT_LT(bright(monitor, 0, 280), full);
}

}  // namespace
}  // namespace stylet::trainer
