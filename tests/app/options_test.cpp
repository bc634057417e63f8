#include "app/options.h"

#include <gtest/gtest.h>

#include <string>

namespace stylet {
namespace {

// The message of the parser, or an empty text if it accepts the value.
template <typename Number>
std::string refusal(Number low, Number high, const std::string& text) {
    CLI::App app;
    Number value{};
    app.add_option("--size", value)->check(inRange(low, high));
    try {
        app.parse("--size=" + text);
    } catch (const CLI::ParseError& e) {
        return e.what();
    }
    return "";
}

TEST(Options, NumbersOutOfRangeAndNanAreRefused) {
    for (const char* good : {"0.5", "5", "1e0"})
        EXPECT_EQ(refusal(0.5, 5.0, good), "") << good;
    for (const std::string bad : {"nan", "NaN", "-nan", "inf", "-inf", "0.49", "5.01", "-1", "x"})
        EXPECT_EQ(refusal(0.5, 5.0, bad), "--size: " + bad + " is not in 0.5 to 5");
    EXPECT_EQ(refusal(1, 64, "64"), "");
    EXPECT_EQ(refusal(1, 64, "65"), "--size: 65 is not in 1 to 64");
    EXPECT_EQ(refusal(1, 64, "nan"), "--size: nan is not in 1 to 64");
}

TEST(Options, HelpShowsTheRange) {
    CLI::App app;
    double value = 1.0;
    app.add_option("--size", value)->check(inRange(0.5, 5.0));
    EXPECT_NE(app.help().find("FLOAT in [0.5 - 5]"), std::string::npos) << app.help();
}

}  // namespace
}  // namespace stylet
