// Golden bytes written by hand from the board's message layout: seven little-endian int16 values in each
// direction.
#include "haptics/devices/woodenhaptics/woodenhaptics_protocol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stylet::haptics {
namespace {

TEST(WoodenProtocol, ReadsAReport) {
    const std::vector<unsigned char> bytes{0x01, 0x00, 0xFE, 0xFF, 0x70, 0x17, 0x00,
                                           0x80, 0xFF, 0x7F, 0x59, 0xFA, 0x01, 0x00};
    const auto report = decodeWoodenReport(bytes);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->encoders, (std::array<std::int16_t, 6>{1, -2, 6000, -32768, 32767, -1447}));
    EXPECT_EQ(report->info, 1);
}

TEST(WoodenProtocol, RefusesAnyOtherLength) {
    std::vector<unsigned char> bytes;
    for (int length = 0; length <= 65; ++length, bytes.push_back(0))
        EXPECT_EQ(decodeWoodenReport(bytes).has_value(), length == 14) << length;
}

TEST(WoodenProtocol, WritesCurrents) {
    EXPECT_EQ(encodeWoodenCurrents({1, -2, 2000}),
              (WoodenCommand{0, 0x01, 0x00, 0xFE, 0xFF, 0xD0, 0x07, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(encodeWoodenCurrents({0, 0, 0}), WoodenCommand{});
}

TEST(WoodenProtocol, WritesACalibration) {
    EXPECT_EQ(encodeWoodenCalibration({8327, -10926, 27140, 0, 30, -1}),
              (WoodenCommand{0, 0x00, 0x00, 0x1E, 0x00, 0xFF, 0xFF, 0x01, 0x00, 0x87, 0x20, 0x52, 0xD5, 0x04,
                             0x6A}));
}

TEST(WoodenProtocol, MilliampsStayWithinTheLimit) {
    EXPECT_EQ(milliamps(0.0016), 2);
    EXPECT_EQ(milliamps(-1.2345), -1235);
    EXPECT_EQ(milliamps(7.0), 2000);
    EXPECT_EQ(milliamps(-1e300), -2000);
    EXPECT_EQ(milliamps(NAN), 0);
    EXPECT_EQ(milliamps(INFINITY), 0);
}

}  // namespace
}  // namespace stylet::haptics
