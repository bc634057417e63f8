#include "app/training/drain_end.h"

#include <algorithm>
#include <span>

namespace stylet::training {

DrainEnd::DrainEnd(const haptics::AccessOutput& access) noexcept
    : count_(std::size_t(access.path_count)), depth_m_(access.drain_m) {
    std::copy_n(access.path_m.begin(), count_, path_m_.begin());
}

Vec3 DrainEnd::at(double back_m) const noexcept {
    return haptics::pointAt({std::span(path_m_).first(count_), depth_m_}, depth_m_ - back_m);
}

std::optional<Vec3> DrainEnd::opening(const patient::Patient& patient, int hole,
                                      double radius_m) const noexcept {
    const Vec3 axis_m = at(haptics::kSideHoles_m * (hole + 0.5) / kHoles);
    if (isDuctTissue(patient, axis_m)) return axis_m;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side_m : {-radius_m, radius_m}) {
            Vec3 beside_m = axis_m;
            beside_m[axis] += side_m;
            if (isDuctTissue(patient, beside_m)) return beside_m;
        }
    return std::nullopt;
}

bool isDuctTissue(const patient::Patient& patient, const Vec3& reference_m) noexcept {
    return patient.at(reference_m, {true, false}).tissue == patient::Tissue::duct;
}

}  // namespace stylet::training
