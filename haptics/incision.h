// What the scalpel opens and the needle passes without the skin's threshold: straight cuts of finite length,
// in the reference, so that the breath carries them.
#pragma once

#include <array>

#include "haptics/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

using patient::Vec3;

struct Incision {
    Vec3 begin_reference_m{0.0}, end_reference_m{0.0};
};

inline constexpr int kMaxIncisions = 8;
struct Incisions {
    int count = 0;
    std::array<Incision, kMaxIncisions> list{};
};

// Haptics thread, all. noexcept, no allocation. Is the skin open within `reach_m` of a point?
bool isOpen(const Incision&, const Vec3& reference_m, double reach_m) noexcept STYLET_NONBLOCKING;
bool isOpen(const Incisions&, const Vec3& reference_m, double reach_m) noexcept STYLET_NONBLOCKING;
void hashIncisions(patient::StateHash&, const Incisions&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
