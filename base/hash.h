// The state hash: 64 bits, updated field by field. Never hash raw structs; their padding is not state.
// Based on XXH64 (Y. Collet, xxHash specification). Uses its round for whole words and its final avalanche.
// The length is left out because it is not known before the end. A tick hashes some hundred words in
// sequence, so the latency of one round determines the cost.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/geometry.h"

namespace stylet {

class StateHash {
  public:
    void add(std::uint64_t bits) noexcept {
        value_ = std::rotl(value_ ^ std::rotl(bits * kPrime2, 31) * kPrime1, 27) * kPrime1 + kPrime4;
    }
    void add(double v) noexcept { add(std::bit_cast<std::uint64_t>(v)); }
    void add(const Vec3& v) noexcept { add(v.x), add(v.y), add(v.z); }
    void add(const Quat& q) noexcept { add(q.w), add(q.x), add(q.y), add(q.z); }
    void add(const Pose& p) noexcept { add(p.rotation), add(p.position_m); }
    void add(std::string_view text) noexcept;
    // Adds several values in order.
    template <typename... Values>
        requires(sizeof...(Values) > 1)
    void add(const Values&... values) noexcept {
        (add(values), ...);
    }
    void addBytes(std::span<const std::byte> bytes) noexcept;
    std::uint64_t value() const noexcept {
        const std::uint64_t a = (value_ ^ value_ >> 33) * kPrime2;
        const std::uint64_t b = (a ^ a >> 29) * kPrime3;
        return b ^ b >> 32;
    }

  private:
    static constexpr std::uint64_t kPrime1 = 0x9e3779b185ebca87ull, kPrime2 = 0xc2b2ae3d27d4eb4full,
                                   kPrime3 = 0x165667b19e3779f9ull, kPrime4 = 0x85ebca77c2b2ae63ull,
                                   kPrime5 = 0x27d4eb2f165667c5ull;
    std::uint64_t value_ = kPrime5;
};

}  // namespace stylet
