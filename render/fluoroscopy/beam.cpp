#include "render/fluoroscopy/beam.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/quaternion.hpp>

namespace stylet::render {

Beam makeBeam(const CArm& arm, const Pose& patient_from_isocentre) {
    const Pose angulated{glm::angleAxis(arm.angulation_rad, Vec3(1.0, 0.0, 0.0)), Vec3(0.0)};
    const Pose slid{glm::angleAxis(arm.orbital_rad, Vec3(0.0, 0.0, 1.0)), Vec3(0.0)};
    const Pose patient_from_arc = patient_from_isocentre * angulated * slid;
    Beam beam;
    beam.source_m = patient_from_arc * Vec3(0.0, -kSourceToIsocentre_m, 0.0);
    beam.detector_m = patient_from_arc * Vec3(0.0, kSourceToDetector_m - kSourceToIsocentre_m, 0.0);
    beam.right = patient_from_arc.direction({-1.0, 0.0, 0.0});
    beam.down = patient_from_arc.direction({0.0, 0.0, -1.0});
    return beam;
}

Vec3 pixelAt(const Beam& beam, int column, int row, int pixels, double side_m) {
    const double x = ((column + 0.5) / pixels - 0.5) * side_m, y = ((row + 0.5) / pixels - 0.5) * side_m;
    return beam.detector_m + x * beam.right + y * beam.down;
}

double openArea_m2(const Collimation& c, double side_m) {
    const auto open = [&](double blade_m) { return std::clamp(blade_m, -0.5 * side_m, 0.5 * side_m); };
    const double left = -open(c.left_m), right = open(c.right_m), top = -open(c.up_m),
                 bottom = open(c.down_m);
    if (right <= left || bottom <= top) return 0.0;
    if (!c.iris_m) return (right - left) * (bottom - top);
    // Integrate column by column: the area of an iris clipped by blades has no short closed form.
    constexpr int kColumns = 2048;
    double area = 0.0;
    for (int i = 0; i < kColumns; ++i) {
        const double x = left + (right - left) * (i + 0.5) / kColumns;
        const double half = std::sqrt(std::max(0.0, *c.iris_m * *c.iris_m - x * x));
        area += std::max(0.0, std::min(bottom, half) - std::max(top, -half));
    }
    return area * (right - left) / kColumns;
}

double openShare(const Collimation& c, double right_m, double down_m, double pixel_m) {
    double inside_m = std::min(std::min(right_m + c.left_m, c.right_m - right_m),
                               std::min(down_m + c.up_m, c.down_m - down_m));
    if (c.iris_m) inside_m = std::min(inside_m, *c.iris_m - std::hypot(right_m, down_m));
    return std::clamp(inside_m / pixel_m + 0.5, 0.0, 1.0);
}

}  // namespace stylet::render
