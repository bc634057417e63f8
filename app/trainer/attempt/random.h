// splitmix64 (Steele et al. 2014) as a stream of random numbers. The standard library is not used because its
// distributions differ between implementations.
#pragma once

#include <cstdint>

namespace stylet::trainer {

struct Random {
    std::uint64_t state;
    double next() noexcept {  // in [0, 1)
        std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return double((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
    }
    double between(double low, double high) noexcept { return low + (high - low) * next(); }
};

}  // namespace stylet::trainer
