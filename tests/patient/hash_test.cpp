#include "patient/hash.h"

#include <gtest/gtest.h>

#include <string>

namespace stylet::patient {
namespace {

std::uint64_t hashOf(std::string_view text) {
    StateHash h;
    h.add(text);
    return h.value();
}

// The first output of the published splitmix64 generator seeded with 0.
TEST(Hash, FoldsWithSplitmix64) {
    StateHash h;
    h.add(std::uint64_t{0});
    EXPECT_EQ(h.value(), 0xe220a8397b1dcdafull);
}

TEST(Hash, TextOfEveryLengthAndEveryByteCounts) {
    std::string text = "a needle's way to the duct";
    for (std::size_t n = 0; n < text.size(); ++n)
        EXPECT_NE(hashOf(text.substr(0, n)), hashOf(text.substr(0, n + 1)));
    const std::uint64_t before = hashOf(text);
    for (char& c : text) {
        c = char(c ^ 1);
        EXPECT_NE(hashOf(text), before);
        c = char(c ^ 1);
    }
}

TEST(Hash, PaddingIsNotContent) {
    EXPECT_NE(hashOf(std::string_view("a\0", 2)), hashOf("a"));
}

TEST(Hash, SignOfZeroAndOrderCount) {
    StateHash a, b;
    a.add(0.0), b.add(-0.0);
    EXPECT_NE(a.value(), b.value());
    StateHash c, d;
    c.add(1.0), c.add(2.0), d.add(2.0), d.add(1.0);
    EXPECT_NE(c.value(), d.value());
}

}  // namespace
}  // namespace stylet::patient
