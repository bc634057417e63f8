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

std::optional<Vec3> DrainEnd::openingIntoDuct(const patient::Patient& patient, double back_m,
                                              double radius_m) const noexcept {
    const auto isDuct = [&](const Vec3& at_m) {
        return patient.at(at_m, {true, false}).tissue == patient::Tissue::duct;
    };
    const Vec3 axis_m = at(back_m);
    if (isDuct(axis_m)) return axis_m;
    for (int direction = 0; direction < 3; ++direction)
        for (const double side_m : {-radius_m, radius_m}) {
            Vec3 beside_m = axis_m;
            beside_m[direction] += side_m;
            if (isDuct(beside_m)) return beside_m;
        }
    return std::nullopt;
}

}  // namespace stylet::training
