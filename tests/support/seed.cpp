#include "tests/support/seed.h"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <string>

namespace stylet::test {

namespace {

std::uint64_t readOrDrawSeed() {
    std::uint64_t seed = 0;
    if (const char* given = std::getenv("STYLET_TEST_SEED")) {
        const std::string text = given;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
        if (error != std::errc() || end != text.data() + text.size())
            throw std::runtime_error("STYLET_TEST_SEED is \"" + text + "\", not a whole number");
    } else {
        seed = std::random_device{}();
    }
    std::printf("random numbers: STYLET_TEST_SEED=%llu repeats them\n",
                static_cast<unsigned long long>(seed));
    std::fflush(stdout);
    return seed;
}

}  // namespace

std::uint64_t seed() {
    static const std::uint64_t drawn = readOrDrawSeed();
    return drawn;
}

}  // namespace stylet::test
