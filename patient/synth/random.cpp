#include "patient/synth/random.h"

#include <cmath>

#include "base/smoothstep.h"

namespace stylet::patient::synth {

namespace {

double latticeValue(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) noexcept {
    const std::uint64_t h =
        mixBits(seed ^ (std::uint64_t(x) * 0x8da6b343u) ^ (std::uint64_t(y) * 0xd8163841ull << 8) ^
                (std::uint64_t(z) * 0xcb1ab31full << 16));
    return double(h >> 11) * 0x1p-52 - 1.0;
}

}  // namespace

double valueNoise(const Vec3& p, std::uint64_t seed) noexcept {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto x = std::int64_t(fx), y = std::int64_t(fy), z = std::int64_t(fz);
    const double u = smoothStep(p.x - fx), v = smoothStep(p.y - fy), w = smoothStep(p.z - fz);
    double plane[2];
    for (int k = 0; k < 2; ++k) {
        const double near =
            latticeValue(x, y, z + k, seed) * (1 - u) + latticeValue(x + 1, y, z + k, seed) * u;
        const double far =
            latticeValue(x, y + 1, z + k, seed) * (1 - u) + latticeValue(x + 1, y + 1, z + k, seed) * u;
        plane[k] = near * (1 - v) + far * v;
    }
    return plane[0] * (1 - w) + plane[1] * w;
}

}  // namespace stylet::patient::synth
