#include "app/trainer/stores/console.h"

#include <gtest/gtest.h>

namespace stylet::trainer {
namespace {

TEST(Console, PopsCompleteLinesWithoutTheirBlanks) {
    std::string typed = "probe\r\n\n  comment a  b \nne";
    EXPECT_EQ(popLine(typed), "probe");
    EXPECT_EQ(popLine(typed), "");
    EXPECT_EQ(popLine(typed), "comment a  b");
    EXPECT_EQ(popLine(typed), std::nullopt);
    EXPECT_EQ(typed, "ne") << "an incomplete line stays";
    EXPECT_EQ(popLine(typed += "xt\n"), "next");
    EXPECT_EQ(typed, "");
}

TEST(Console, HelpIsATable) {
    EXPECT_EQ(helpLine("park", "park the probe where it is"),
              "  park            park the probe where it is\n");
    EXPECT_EQ(helpLine("a command that is long", "?"), "  a command that is long?\n");
}

}  // namespace
}  // namespace stylet::trainer
