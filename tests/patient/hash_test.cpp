#include "base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

namespace stylet::patient {
namespace {

std::uint64_t computeHash(std::string_view text) {
    StateHash h;
    h.add(text);
    return h.value();
}

// XXH64 of up to three whole words, implemented from its specification.
std::uint64_t xxh64(const std::vector<std::uint64_t>& words, std::uint64_t seed) {
    const std::uint64_t p1 = 11400714785074694791u, p2 = 14029467366897019727u, p3 = 1609587929392839161u,
                        p4 = 9650029242287828579u, p5 = 2870177450012600261u;
    std::uint64_t acc = seed + p5 + 8 * words.size();
    for (const std::uint64_t word : words) {
        acc ^= std::rotl(word * p2, 31) * p1;
        acc = std::rotl(acc, 27) * p1 + p4;
    }
    acc ^= acc >> 33, acc *= p2;
    acc ^= acc >> 29, acc *= p3;
    return acc ^ acc >> 32;
}

TEST(Hash, IsXxh64WithoutTheLength) {
    ASSERT_EQ(xxh64({0x6867666564636261u}, 0), 0x3ad351775b4634b7u);  // the published hash of "abcdefgh"
    StateHash h;
    EXPECT_EQ(h.value(), 0xef46db3751d8e999u);  // the published hash of empty input
    std::vector<std::uint64_t> words;
    for (const double x : {1.0, -0.0, 0.0125}) {
        h.add(x);
        words.push_back(std::bit_cast<std::uint64_t>(x));
        EXPECT_EQ(h.value(), xxh64(words, 0 - 8 * words.size()));
    }
}

// A change of any bit of any word changes about half of the 64 bits.
TEST(Hash, EveryBitReachesHalfOfTheValue) {
    double fewest = 64.0, most = 0.0;
    for (std::size_t word = 0; word < 4; ++word) {
        for (int bit = 0; bit < 64; ++bit) {
            double changed = 0.0;
            for (std::uint64_t sample = 0; sample < 200; ++sample) {
                StateHash a, b;
                for (std::size_t i = 0; i < 4; ++i) {
                    const std::uint64_t x = std::bit_cast<std::uint64_t>(0.001 * double(7 * sample + i));
                    a.add(x), b.add(i == word ? x ^ std::uint64_t{1} << bit : x);
                }
                changed += std::popcount(a.value() ^ b.value()) / 200.0;
            }
            fewest = std::min(fewest, changed), most = std::max(most, changed);
        }
    }
    EXPECT_GT(fewest, 30.0);
    EXPECT_LT(most, 34.0);
}

TEST(Hash, DependsOnLengthAndEveryByteOfText) {
    std::string text = "a needle's way to the duct";
    for (std::size_t n = 0; n < text.size(); ++n)
        EXPECT_NE(computeHash(text.substr(0, n)), computeHash(text.substr(0, n + 1)));
    const std::uint64_t before = computeHash(text);
    for (char& c : text) {
        c = char(c ^ 1);
        EXPECT_NE(computeHash(text), before);
        c = char(c ^ 1);
    }
}

TEST(Hash, PaddingDiffersFromContent) {
    EXPECT_NE(computeHash(std::string_view("a\0", 2)), computeHash("a"));
}

TEST(Hash, DependsOnSignOfZeroAndOrder) {
    StateHash a, b;
    a.add(0.0), b.add(-0.0);
    EXPECT_NE(a.value(), b.value());
    StateHash c, d;
    c.add(1.0), c.add(2.0), d.add(2.0), d.add(1.0);
    EXPECT_NE(c.value(), d.value());
}

}  // namespace
}  // namespace stylet::patient
