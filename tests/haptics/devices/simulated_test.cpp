#include "haptics/devices/simulated.h"

#include <gtest/gtest.h>

namespace stylet::haptics {
namespace {

TEST(SimulatedDevice, FollowsItsTraceFromItsStart) {
    Trace trace;
    trace.samples = {{0, {{}, {0.0, 0.0, 0.0}}, 0}, {1000, {{}, {1.0, 0.0, 0.0}}, 5}};
    SimulatedDevice device(trace, 500, {"weak", 1.0, 100.0, ""});
    EXPECT_EQ(device.read(1000).device_from_stylus.position_m.x, 0.5);
    const DeviceState last = device.read(9000);
    EXPECT_EQ(last.device_from_stylus.position_m.x, 1.0);
    EXPECT_EQ(last.buttons, 5u);
    EXPECT_EQ(last.fresh, 1u);
    EXPECT_EQ(device.profile().force_peak_n, 1.0);
    device.send({0.0, 2.0, 0.0});
    EXPECT_EQ(device.force().y, 2.0);
}

}  // namespace
}  // namespace stylet::haptics
