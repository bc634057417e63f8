// Random numbers as a function of (seed, stream, counter). The standard library is not used because its
// distributions differ between implementations.
#pragma once

#include <cstdint>

#include "base/geometry.h"

namespace stylet::patient::synth {

// splitmix64's finaliser (Steele et al. 2014): every input bit reaches every output bit.
constexpr std::uint64_t mixBits(std::uint64_t z) noexcept {
    z += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

class Random {
  public:
    Random(std::uint64_t seed, std::uint64_t stream) noexcept
        : key_(mixBits(mixBits(seed) ^ (stream << 17))) {}

    std::uint64_t bits() noexcept { return mixBits(key_ ^ ++counter_ * 0xd1342543de82ef95ull); }
    double unit() noexcept { return double(bits() >> 11) * 0x1p-53; }  // [0, 1)
    double uniform(double low, double high) noexcept { return low + (high - low) * unit(); }
    // Triangular distribution around zero, within +-limit.
    double jitter(double limit) noexcept { return limit * (unit() + unit() - 1.0); }
    Vec3 jitter3(double limit) noexcept {
        const double x = jitter(limit), y = jitter(limit), z = jitter(limit);
        return {x, y, z};
    }

    // A point in a box. Draws x, y and z in this order.
    Vec3 uniform3(const Vec3& low, const Vec3& high) noexcept {
        const double x = uniform(low.x, high.x), y = uniform(low.y, high.y), z = uniform(low.z, high.z);
        return {x, y, z};
    }

  private:
    std::uint64_t key_, counter_ = 0;
};

// Value noise on the integer lattice, smooth (C1), in [-1, 1].
double valueNoise(const Vec3& p, std::uint64_t seed) noexcept;

}  // namespace stylet::patient::synth
