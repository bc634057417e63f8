#include "base/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>

namespace stylet {
namespace {

TEST(ParseNumber, AcceptsTheWholeTextOnly) {
    EXPECT_EQ(parseNumber<int>("-12"), -12);
    EXPECT_EQ(parseNumber<double>("1e-3"), 1e-3);
    for (const char* bad : {"", " 1", "1 ", "+1", "1,5", "0x1", "1.5.2", "one"}) {
        EXPECT_FALSE(parseNumber<int>(bad)) << bad;
        EXPECT_FALSE(parseNumber<double>(bad)) << bad;
    }
    EXPECT_FALSE(parseNumber<std::uint8_t>("256"));
    EXPECT_FALSE(parseNumber<unsigned>("-1"));
    EXPECT_FALSE(parseNumber<double>("1e999"));
}

TEST(Capitalised, ChangesOnlyAFirstLetterOfAscii) {
    EXPECT_EQ(capitalised("bile"), "Bile");
    for (const char* same : {"", "Bile", "1 ml", "\u00e4rger"})
        EXPECT_EQ(capitalised(same), same);
}

TEST(ShortestText, ReadsBackToTheSameBits) {
    EXPECT_EQ(shortestText(0.1), "0.1");
    EXPECT_EQ(shortestText(std::numeric_limits<std::int64_t>::min()), "-9223372036854775808");
    for (const double value : {1.0 / 3.0, -0.0, 1e300, 5e-324, std::numeric_limits<double>::lowest()}) {
        const auto back = parseNumber<double>(shortestText(value));
        ASSERT_TRUE(back);
        EXPECT_EQ(*back, value);
        EXPECT_EQ(std::signbit(*back), std::signbit(value));
    }
}

TEST(Trimmed, RemovesBlanksAtBothEnds) {
    EXPECT_EQ(trimmed(" \t a b\r"), "a b");
    EXPECT_EQ(trimmed(" \t "), "");
    EXPECT_EQ(trimmed(""), "");
}

TEST(EnumNames, NameAndValueBelongTogether) {
    enum class Colour { red, green };
    constexpr std::array<std::string_view, 2> kNames{"red", "green"};
    EXPECT_EQ(enumName(kNames, Colour::green), "green");
    EXPECT_EQ(findEnum<Colour>(kNames, "green"), Colour::green);
    EXPECT_EQ(enumName(kNames, Colour(2)), "?");
    EXPECT_FALSE(findEnum<Colour>(kNames, "?"));
}

}  // namespace
}  // namespace stylet
