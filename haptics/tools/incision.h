// Incisions: straight cuts of finite length, made by the scalpel. The needle passes them without the skin's
// puncture threshold. They are stored in the reference frame, so they move with breathing.
#pragma once

#include <array>
#include <span>

#include "base/hash.h"
#include "base/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

struct Incision {
    Vec3 begin_reference_m{0.0}, end_reference_m{0.0};
};

inline constexpr int kMaxIncisions = 8;
struct Incisions {
    int count = 0;
    std::array<Incision, kMaxIncisions> list{};

    std::span<const Incision> made() const noexcept { return std::span(list).first(std::size_t(count)); }
};

// All functions: haptics thread. noexcept, no allocation.
// isOpen() returns true if the point lies within `reach_m` of an incision.
bool isOpen(const Incision&, const Vec3& reference_m, double reach_m) noexcept STYLET_NONBLOCKING;
bool isOpen(const Incisions&, const Vec3& reference_m, double reach_m) noexcept STYLET_NONBLOCKING;
void hashIncisions(StateHash&, const Incisions&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
