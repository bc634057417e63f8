#include "haptics/tools/incision.h"
#include "base/hash.h"

#include <algorithm>

namespace stylet::haptics {

namespace {

double squaredDistance(const Incision& cut, const Vec3& p) noexcept {
    const Vec3 along = cut.end_reference_m - cut.begin_reference_m, from = p - cut.begin_reference_m;
    const double length2 = glm::dot(along, along);
    const double share = length2 > 0.0 ? std::clamp(glm::dot(from, along) / length2, 0.0, 1.0) : 0.0;
    const Vec3 off = from - share * along;
    return glm::dot(off, off);
}

}  // namespace

bool isOpen(const Incision& cut, const Vec3& reference_m, double reach_m) noexcept {
    return squaredDistance(cut, reference_m) <= reach_m * reach_m;
}

bool isOpen(const Incisions& incisions, const Vec3& reference_m, double reach_m) noexcept {
    for (const Incision& cut : incisions.made())
        if (isOpen(cut, reference_m, reach_m)) return true;
    return false;
}

void hashIncisions(StateHash& hash, const Incisions& incisions) noexcept {
    hash.add(std::uint64_t(incisions.count));
    for (const Incision& cut : incisions.made())
        hash.add(cut.begin_reference_m, cut.end_reference_m);
}

}  // namespace stylet::haptics
