#include "base/hex.h"

#include <gtest/gtest.h>

namespace stylet {
namespace {

TEST(Hex, WritesSixteenLowerCaseDigits) {
    EXPECT_EQ(hexText(0), "0000000000000000");
    EXPECT_EQ(hexText(0xabcu), "0000000000000abc");
    EXPECT_EQ(hexText(0x0123456789abcdefu), "0123456789abcdef");
    EXPECT_EQ(hexText(~std::uint64_t(0)), "ffffffffffffffff");
}

TEST(Hex, WritesTheLowestDigits) {
    EXPECT_EQ(hexText(0x7fu, 2), "7f");
    EXPECT_EQ(hexText(0x0au, 2), "0a");
    EXPECT_EQ(hexText(0x12345678u, 8), "12345678");
    EXPECT_EQ(hexText(0x12345678u, 4), "5678");
}

TEST(Hex, ParsesWhatItWrites) {
    for (const std::uint64_t value : {std::uint64_t(0), std::uint64_t(0xfeedull), ~std::uint64_t(0)})
        EXPECT_EQ(parseHex(hexText(value)), value);
    EXPECT_EQ(parseHex("00000000DEADBEEF"), 0xdeadbeefu);
}

TEST(Hex, RejectsMalformedText) {
    for (const char* text : {"", "0", "000000000000000", "00000000000000000", "0x00000000000000",
                             "-000000000000001", "+000000000000001", " 00000000000000a", "000000000000000g"})
        EXPECT_FALSE(parseHex(text)) << text;
}

}  // namespace
}  // namespace stylet
