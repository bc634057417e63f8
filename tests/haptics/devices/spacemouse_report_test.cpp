// Golden bytes written by hand: report id, then little-endian int16 values.
#include "haptics/devices/spacemouse/spacemouse_report.h"

#include <gtest/gtest.h>

#include <vector>

namespace stylet::haptics {
namespace {

using Bytes = std::vector<unsigned char>;
using RawAxes = std::array<int, 6>;
constexpr auto kMotion = SpaceMouseReport::motion, kOther = SpaceMouseReport::other,
               kMalformed = SpaceMouseReport::malformed;

TEST(SpaceMouseReport, OldDevicesSendTranslationAndRotationSeparately) {
    SpaceMouseInput input;
    EXPECT_EQ(parseSpaceMouseReport(Bytes{1, 0x5E, 0x01, 0xA2, 0xFE, 0x0A, 0x00}, input), kMotion);
    EXPECT_EQ(input.axes, (RawAxes{350, -350, 10, 0, 0, 0}));
    EXPECT_EQ(parseSpaceMouseReport(Bytes{2, 0x01, 0x00, 0xFF, 0xFF, 0x64, 0x00}, input), kMotion);
    EXPECT_EQ(input.axes, (RawAxes{350, -350, 10, 1, -1, 100}));
    EXPECT_FALSE(input.atRest());
    parseSpaceMouseReport(Bytes{1, 0, 0, 0, 0, 0, 0}, input);
    parseSpaceMouseReport(Bytes{2, 0, 0, 0, 0, 0, 0}, input);
    EXPECT_TRUE(input.atRest());
}

TEST(SpaceMouseReport, NewDevicesSendSixAxesAtOnce) {
    SpaceMouseInput input;
    EXPECT_EQ(parseSpaceMouseReport(
                  Bytes{1, 0x5E, 0x01, 0xA2, 0xFE, 0x0A, 0x00, 0x01, 0x00, 0xFF, 0xFF, 0x64, 0x00}, input),
              kMotion);
    EXPECT_EQ(input.axes, (RawAxes{350, -350, 10, 1, -1, 100}));
}

TEST(SpaceMouseReport, ButtonsAndBattery) {
    SpaceMouseInput input;
    EXPECT_EQ(parseSpaceMouseReport(Bytes{3, 0x02, 0x00}, input), kOther);
    EXPECT_EQ(input.buttons, 2u);
    EXPECT_EQ(parseSpaceMouseReport(Bytes{3, 0x01, 0x00, 0x00, 0x80, 0xFF}, input), kOther);
    EXPECT_EQ(input.buttons, 0x80000001u);
    EXPECT_EQ(parseSpaceMouseReport(Bytes{0x17, 0x4B, 0x00}, input), kOther);
    EXPECT_EQ(input.battery_percent, 75);
    EXPECT_EQ(parseSpaceMouseReport(Bytes{28, 1, 2, 3}, input), kOther) << "the Enterprise's own keys";
    EXPECT_EQ(input.buttons, 0x80000001u);
}

// HZ-FORCE-21
TEST(SpaceMouseReport, RefusesBadLengthsAndAxesOutOfRange) {
    SpaceMouseInput input;
    for (std::size_t length = 0; length < 20; ++length) {
        Bytes bytes(length, 0);
        for (const unsigned char id : {1, 2}) {
            if (length > 0) bytes[0] = id;
            const bool fits = length == 7 || (id == 1 && length == 13);
            EXPECT_EQ(parseSpaceMouseReport(bytes, input), fits ? kMotion : kMalformed)
                << int(id) << " with " << length;
        }
    }
    EXPECT_EQ(parseSpaceMouseReport(Bytes{1, 0x00, 0x00, 0xFF, 0x7F, 0x00, 0x00}, input), kMalformed);
    EXPECT_EQ(parseSpaceMouseReport(Bytes{1, 0x00, 0x00, 0x00, 0x80, 0x00, 0x00}, input), kMalformed);
    EXPECT_EQ(parseSpaceMouseReport(Bytes{0x17, 0xC8}, input), kMalformed);
    EXPECT_TRUE(input.atRest());
}

TEST(SpaceMouseReport, DistinguishesSpaceMiceFromMiceAndKeyboards) {
    for (const std::uint16_t product : {0xc603, 0xc626, 0xc629, 0xc62b})
        EXPECT_TRUE(isSpaceMouse(0x046d, product, 1, 8)) << product;
    for (const std::uint16_t product : {0xc62e, 0xc62f, 0xc635, 0xc638, 0xc652})
        EXPECT_TRUE(isSpaceMouse(0x256f, product, 1, 8)) << product;
    for (const std::uint16_t product : {0xc650, 0xc651, 0xc654, 0xc658, 0xc664, 0xc668})
        EXPECT_FALSE(isSpaceMouse(0x256f, product, 1, 8)) << product;
    EXPECT_FALSE(isSpaceMouse(0x046d, 0xc62c, 1, 8));
    EXPECT_FALSE(isSpaceMouse(0x046d, 0xc641, 1, 8));
    EXPECT_FALSE(isSpaceMouse(0x1234, 0xc626, 1, 8));
    EXPECT_TRUE(isSpaceMouse(0x256f, 0xc635, 0, 0)) << "the descriptor could not be read";
    EXPECT_FALSE(isSpaceMouse(0x256f, 0xc652, 1, 6)) << "the receiver's keyboard";
}

}  // namespace
}  // namespace stylet::haptics
