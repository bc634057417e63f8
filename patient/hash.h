// The state hash: 64 bits folded field by field (never over raw structs, whose padding is not state).
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string_view>

#include "patient/geometry.h"

namespace stylet::patient {

class StateHash {
  public:
    void add(std::uint64_t bits) noexcept {
        // splitmix64's finaliser over (state xor input): every input bit reaches every output bit.
        std::uint64_t z = (value_ ^ bits) + 0x9e3779b97f4a7c15ull;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        value_ = z ^ (z >> 31);
    }
    void add(double v) noexcept { add(std::bit_cast<std::uint64_t>(v)); }
    void add(const Vec3& v) noexcept { add(v.x), add(v.y), add(v.z); }
    void add(const Quat& q) noexcept { add(q.w), add(q.x), add(q.y), add(q.z); }
    void add(const Pose& p) noexcept { add(p.rotation), add(p.position_m); }
    void add(std::string_view text) noexcept;
    void addBytes(std::span<const std::byte> bytes) noexcept;
    std::uint64_t value() const noexcept { return value_; }

  private:
    std::uint64_t value_ = 0;
};

}  // namespace stylet::patient
